// Stage 2, trace: the nearest hit of every active ray.
//
//   in    rays and queue of this bounce, BVH
//   out   hits[slot]; with LAYERS and ALPHA, paths[slot].throughput of rays through coloured panes
//   next  sort
//
// Variants: PERSISTENT fetches work from counters.trace_head (lib/queue.h), with BVH_QUAD and
// WARP_VOTES lane by lane (lib/trace_refill.h), else one ray an item; RAY_SPANS: rays carry how
// near and how far they look, else they look ahead without end; NODES_IMAGE reads nodes through a
// 1D texture; ALPHA asks materials whether they let a ray by, LAYERS also those that are thin and
// smooth; ANY_HIT: whether there is a hit, of any triangle: hits[slot].triangle is 0 or HIT_NONE.

#include "lib/queue.h"
#include "lib/traverse.h"
#include "lib/trace_refill.h"
#include "shared/path.h"

#if ANY_HIT
#define TRACE_ANY true
#else
#define TRACE_ANY false
#endif

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void trace(
    TRACED_PARAMETERS, __global const struct ray *restrict rays,
    __global const uint *restrict queue, __global struct hit *restrict hits,
    __global struct counters *counters, const uint bounce
#if ALPHA && LAYERS
    ,
    __global struct path *restrict paths
#endif
)
{
    TRACED_SCENE(scene);
    const uint count = counters[bounce].active;
#if TRACE_REFILLS
    trace_refilling(nodes, &scene, rays, queue, hits, &counters[bounce].trace_head, count, TRACE_ANY
#if ALPHA && LAYERS
                    ,
                    paths
#endif
    );
#else
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].trace_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].trace_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        const float3 org = rays[slot].org.xyz;
        const float3 dir = rays[slot].dir.xyz;
#if RAY_SPANS
        const float tmin = rays[slot].org.w;
        const float tmax = rays[slot].dir.w;
#else
        const float tmin = 0.0f;
        const float tmax = FLT_MAX;
#endif
#if ALPHA && LAYERS
        struct passage passage;
        passage_init(&passage);
        const struct hit hit = traverse_through(nodes, &scene, org, dir, tmin, tmax, TRACE_ANY,
                                                &passage, PASSAGE_CHANCE);
        hits[slot] = hit;
        if (passage.tinted) {
            // What was tested beyond the hit has no part in it.
            traverse_through(nodes, &scene, org, dir, tmin, hit.t, false, &passage, PASSAGE_TINT);
            paths[slot].throughput_bits.xyz *= passage.share;
        }
#else
        struct hit hit = traverse(nodes, &scene, org, dir, tmin, tmax, TRACE_ANY);
        if (TRACE_ANY) // which one was not asked, and is a read less
            hit.triangle = hit.triangle == HIT_NONE ? HIT_NONE : 0;
        hits[slot] = hit;
#endif
    }
#endif
}
