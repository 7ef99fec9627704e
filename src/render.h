/**
 * @file
 * The loop over batches of paths: how many at a time, when to stop, what to tell while it runs.
 */
#ifndef RENDER_H
#define RENDER_H

#include <stdint.h>

#include "core/status.h"
#include "engine.h"
#include "film/film.h"
#include "pipeline/pipeline.h"

/** Everything a render holds on its device. All zero is a valid empty one. */
struct renderer {
    struct gpu gpu;
    struct device_scene scene;
    struct wavefront wavefront;
    struct pipeline pipeline;
    struct film film;
    struct settings settings; // of the kernels
    struct camera camera;
    struct sequence sequence; // where it stands
    double start_s;           // when lk_render() was called, clock_seconds()
};

/**
 * Renders until a limit of the settings is met or the hook says no.
 *
 * The sequence of paths (film/sequence.h) is cut into batches of as many paths as the device
 * finishes in BATCH_SECONDS, so that no launch comes near a watchdog and a cancel is heard soon.
 * Nothing in the result depends on the cuts.
 *
 * @param info  rays, paths, spp, times of render and kernel_build are added.
 * @retval STATUS_CANCELLED  The hook returned false; what was finished counts.
 */
enum status render_paths(struct renderer *renderer, struct lk_render_info *info,
                         const struct lk_progress_hook *hook);

/** Calls the hook. STATUS_CANCELLED if it says no. */
enum status render_report(const struct lk_progress_hook *hook, const struct lk_progress *progress);

/** Releases everything. */
void renderer_free(struct renderer *renderer);

#endif
