/**
 * @file
 * Rays of one's own, traced through a scene.
 */
#ifndef LIGHTKILN_TRACER_H
#define LIGHTKILN_TRACER_H

#include <stdbool.h>
#include <stdint.h>

#include "lightkiln/device.h"
#include "lightkiln/scene.h"
#include "lightkiln/settings.h"
#include "lightkiln/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** A ray of the caller's, world space. */
struct lk_ray {
    float org[3]; // m
    float tmin;   // nearest hit accepted, m
    float dir[3]; // unit vector
    float tmax;   // farthest hit accepted, m
};

#define LK_HIT_NONE 0xffffffffu

/** Where a ray ends. */
struct lk_hit {
    float t;           // distance, m
    float u, v;        // weights of the triangle's second and third corner
    uint32_t triangle; // or LK_HIT_NONE
};

/** What a ray visits on average. */
struct lk_visits {
    double nodes;     // of the binary BVH, each with the boxes of two children
    double triangles; // tested
};

/**
 * Counts, on the host, what rays visit of a scene's binary BVH: how hard they are to trace,
 * whatever traces them. All triangles are solid.
 *
 * @param settings  All that concerns building the BVH is looked at.
 * @param rays      [count]
 * @param step      Every step-th of them is looked at: 1 at least.
 * @param any_hit   They end at the first hit found.
 * @retval LK_USAGE (a step of 0), LK_NO_MEMORY, LK_FORMAT, LK_LIMIT
 */
LK_API enum lk_status lk_scene_visits(struct lk_visits *out, struct lk_scene *scene,
                                      const struct lk_settings *settings, const struct lk_ray *rays,
                                      uint32_t count, uint32_t step, bool any_hit);

/** A scene's triangles on a device, to trace rays of one's own. All of them are solid, whatever
 * their materials say. Opaque. */
struct lk_tracer;

/** What a tracer is made of. */
struct lk_tracer_info {
    struct lk_device_info device;
    struct lk_settings settings; // with every default that matters here filled in; borrowed strings
    uint32_t width, height;      // of the camera's image; width * height rays fit
    uint64_t references;         // to triangles that the builder made
    uint64_t bvh_size;           // bytes on the device
    double build_s;              // building and packing the BVH took
};

/**
 * Prepares the triangles, opens a device and builds the kernels. Nothing is measured: what the
 * settings leave open goes by the kind of the device.
 *
 * @param settings  Device, camera, width, height, seed, and all that concerns BVH and traversal are
 * looked at. The strings must outlive the tracer.
 * @retval as lk_render()
 */
LK_API enum lk_status lk_tracer_create(struct lk_tracer **out, struct lk_scene *scene,
                                       const struct lk_settings *settings);

/** Releases it. NULL is accepted. */
LK_API void lk_tracer_free(struct lk_tracer *tracer);

/** Borrowed from the tracer. */
LK_API const struct lk_tracer_info *lk_tracer_info(const struct lk_tracer *tracer);

/** Makes the camera's rays, one a pixel in the order of the ray queue, as a render's first sample
 * has them. @param[out] rays [width * height] */
LK_API enum lk_status lk_tracer_camera_rays(struct lk_tracer *tracer, struct lk_ray *rays);

/** Copies rays to the device: [count], at most width * height. */
LK_API enum lk_status lk_tracer_set_rays(struct lk_tracer *tracer, const struct lk_ray *rays,
                                         uint32_t count);

#define LK_LAUNCHES_MAX 64

/**
 * Traces the rays and waits.
 *
 * @param[out] seconds  One launch took, on average. NULL: not asked for.
 * @param any_hit       Ask only whether there is a hit: of lk_hit, only triangle has a meaning, and
 * is 0 or LK_HIT_NONE.
 * @param launches      Times to do it, back to back, 1 .. LK_LAUNCHES_MAX.
 */
LK_API enum lk_status lk_tracer_run(struct lk_tracer *tracer, double *seconds, bool any_hit,
                                    uint32_t launches);

/** Copies the hits of the last run: [count of the rays set]. */
LK_API enum lk_status lk_tracer_hits(struct lk_tracer *tracer, struct lk_hit *hits);

#ifdef __cplusplus
}
#endif

#endif
