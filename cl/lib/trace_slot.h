/**
 * @file
 * The nearest hit of one path's ray. For cl/trace.cl, and for cl/bounce.cl.
 */
#ifndef LIB_TRACE_SLOT_H
#define LIB_TRACE_SLOT_H

#include "lib/traverse.h"
#include "shared/path.h"

#if ANY_HIT
#define TRACE_ANY true
#else
#define TRACE_ANY false
#endif

#if ALPHA && LAYERS
#define TRACE_TINTS 1
#endif

// What takes paths whose rays may be given colours.
#if TRACE_TINTS
#define TRACE_PATHS          , __global struct path *paths
#define TRACE_PATHS_ARGUMENT , paths
#else
#define TRACE_PATHS
#define TRACE_PATHS_ARGUMENT
#endif

// Reads a ray; w are the nearest and the farthest hit that it accepts.
static inline struct ray trace_load(__global const struct ray *rays, const uint slot)
{
    struct ray ray = rays[slot];
#if !RAY_SPANS
    ray.org.w = 0.0f;
    ray.dir.w = FLT_MAX;
#endif
    return ray;
}

#if TRACE_TINTS

// Gives a ray that has gone through something coloured its colour. What was tested beyond the hit
// has no part in it.
static inline void trace_tint(BVH_NODES nodes, const struct traced *scene, const struct ray ray,
                              const float t, __global struct path *path)
{
    struct passage passage;
    passage_init(&passage);
    traverse_through(nodes, scene, ray.org.xyz, ray.dir.xyz, ray.org.w, t, false, &passage,
                     PASSAGE_TINT);
    path->throughput_bits.xyz *= passage.share;
}

#endif

// Traces the ray of one slot. With TRACE_ANY the hit tells no more than whether there is one.
static inline struct hit trace_slot(BVH_NODES nodes, const struct traced *scene,
                                    __global const struct ray *rays, const uint slot TRACE_PATHS)
{
    const struct ray ray = trace_load(rays, slot);
    struct passage passage;
    passage_init(&passage);
    const struct hit hit = traverse_through(nodes, scene, ray.org.xyz, ray.dir.xyz, ray.org.w,
                                            ray.dir.w, TRACE_ANY, &passage, PASSAGE_CHANCE);
#if TRACE_TINTS
    if (passage.tinted)
        trace_tint(nodes, scene, ray, hit.t, &paths[slot]);
#endif
    return hit;
}

#endif
