/**
 * @file
 * One device of a render: everything it holds there, and the loop over batches of paths.
 */
#ifndef RENDERER_H
#define RENDERER_H

#include <stdint.h>

#include "core/status.h"
#include "choice.h"
#include "engine.h"
#include "film/film.h"
#include "pipeline/pipeline.h"
#include "shared/camera.h"
#include "shared/settings.h"

/** Rays traced. */
struct ray_counts {
    uint64_t camera, indirect, shadow;
    uint64_t directional; // those of shadow towards directional lights and surroundings
};

/** All zero is a valid empty one. */
struct renderer {
    struct gpu gpu;
    struct gpu timed;          // a queue to it, while a probe runs
    struct lk_settings chosen; // the render's, with what this device leaves open filled in; trace
                               // and bvh by the rule,
    struct choice choice;      // this tells what is taken
    struct lk_memory memory;   // that it takes
    struct camera camera;
    struct device_scene scene;
    struct wavefront wavefront;
    struct pipeline pipeline;
    struct film film;
    struct settings settings;  // of the kernels
    struct counters *counters; // [bounce_count] as they were read last; owned
    struct counters *before;   // [bounce_count] as they were read before that; in the same block
    uint32_t batch_paths;      // of the next batch
    uint32_t batch_run;        // batches that are enqueued before the next wait
    struct ray_counts rays;
    double upload_s, build_s; // they took
    double busy_s;            // spans took, where the work is shared
    uint32_t built;           // programs compiled from source
};

/** Opens a device and chooses what the settings leave open by it. Fails as gpu_open() and
 * settings_check_device(). */
enum status renderer_open(struct renderer *out, const struct gpu_info *info,
                          const struct lk_settings *settings, uint32_t spare_units);

/** Chooses anew among what the rule's layout of the BVH allows alone: to save memory. */
void renderer_narrow(struct renderer *renderer, const struct lk_settings *settings,
                     const struct lk_scene *scene);

/**
 * Uploads a prepared scene, builds the kernels and makes the buffers.
 *
 * A choice that is open is decided by a probe. A form of kernels that does not work is replaced by
 * the plain one, with a warning, unless the settings force it.
 *
 * @param renderer  Opened; its camera and the queue in `chosen` are set.
 */
enum status renderer_set_up(struct renderer *renderer, const struct lk_scene *scene);

/**
 * Renders the next batch of a sequence, and waits for it; or a run of batches, where a full queue
 * is done so soon that the wait would be felt.
 *
 * A batch has as many paths as the device finishes in BATCH_SECONDS, as the batches before tell, so
 * that no launch comes near a watchdog and a cancel is heard soon. Nothing in the result depends on
 * the cuts.
 *
 * @param tells  Whether its time tells: a first batch also waits for kernels that are compiled when
 * first launched, as PoCL's are.
 */
enum status renderer_batch(struct renderer *renderer, struct sequence *sequence, bool tells);

/** Releases everything. */
void renderer_free(struct renderer *renderer);

#endif
