/**
 * @file
 * A render: on one device, or shared among several; how it goes on, when it stops, what is told
 * while it runs.
 */
#ifndef RENDER_H
#define RENDER_H

#include <stdint.h>

#include "core/status.h"
#include "engine.h"
#include "film/canvas.h"
#include "renderer.h"

/** All zero is a valid empty one. */
struct render {
    const struct lk_scene *scene; // prepared
    struct lk_render_info *info;
    const struct lk_progress_hook *hook; // NULL: none
    struct renderer *renderers;          // [renderer_count], opened; owned
    size_t renderer_count;
    struct canvas canvas;
    double start_s; // when lk_render() was called, clock_seconds()
};

/** How far a render has come. */
struct render_state {
    uint64_t paths;       // finished
    uint64_t timed_paths; // those finished within `seconds`
    double seconds;       // of rendering
    struct ray_counts rays;
    double noise; // relative error reached; not above 0: not known
};

/**
 * Renders until a limit of the settings is met or the hook says no.
 *
 * @retval STATUS_CANCELLED  The hook returned false; what was finished is on the canvas.
 */
enum status render_paths(struct render *render);

/** Calls the hook, if there is one. STATUS_CANCELLED if it says no. */
enum status render_report(const struct lk_progress_hook *hook, const struct lk_progress *progress);

/** Tells the hook how far the rendering has come. */
enum status render_progress(const struct render *render, const struct render_state *state);

/** Releases everything. */
void render_free(struct render *render);

#endif
