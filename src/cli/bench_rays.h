/**
 * @file
 * The rays that tracing is measured with: those of a path tracer on a scene without materials.
 *
 * Primary rays come from the camera, or from views of places along its paths (cli/bench_views.h).
 * Each bounce leaves the hits of the last one about the face's
 * normal, as Lambert's law says. Shadow rays go from the primary hits to a light each, drawn from
 * all of them, where it shines on the face.
 */
#ifndef CLI_BENCH_RAYS_H
#define CLI_BENCH_RAYS_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "lightkiln/lightkiln.h"

enum ray_class {
    RAYS_PRIMARY,
    RAYS_BOUNCE_1,
    RAYS_BOUNCE_4 = RAYS_BOUNCE_1 + 3,
    RAYS_SHADOW,
    RAY_CLASSES
};

/** "primary", "bounce 1". */
extern const char *const ray_class_names[RAY_CLASSES];

/** The rays of one class. All zero: none. */
struct ray_set {
    struct lk_ray *rays; // [count]; owned
    uint32_t count;
    bool any_hit; // what is asked of them
};

/**
 * Makes the rays of all classes, in the order of the ray queue. The same scene and settings give
 * the same rays.
 *
 * @param[out] out  [RAY_CLASSES], each to be freed; written on success only.
 * @param tracer    Traces the hits that bounces start from.
 * @param views     That primary rays come from; 1: the camera's.
 * @retval as views_make()
 */
enum status ray_sets_make(struct ray_set *out, struct lk_scene *scene, struct lk_tracer *tracer,
                          uint32_t views);

void ray_sets_free(struct ray_set *sets);

/** Traces a set's nearest hits: [set->count]. */
enum status ray_set_trace(struct lk_hit *hits, struct lk_tracer *tracer, const struct ray_set *set);

/** A corner of a triangle, m. */
const float *ray_corner(const struct lk_geometry *geometry, uint32_t triangle, int corner);

#endif
