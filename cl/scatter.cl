// Stage 7, scatter: the direction in which a path goes on from its shaded hit; those that do become
// the next bounce's queue.
//
//   in    paths, rays, shades, queue of this bounce
//   out   paths, rays, queue_out, counters[bounce + 1].active
//   next  trace
//
// Variants: those of lib/bsdf.h. A kernel of its own only where no light is added, or forms are
// compared: else direct or directional sends paths on.

#include "lib/scatter.h"

#ifndef WG_SCATTER
#define WG_SCATTER (SHADE_LANES ? 1 : 64) // work items in a group
#endif

__kernel __attribute__((reqd_work_group_size(WG_SCATTER, 1, 1))) void scatter(
    __constant struct settings *settings, const struct batch batch, const uint bounce,
    __global struct counters *counters, __global const uint *restrict queue,
    __global const struct shade *restrict shades, __global struct ray *restrict rays,
    __global struct path *restrict paths, __global const uint4 *restrict points,
    __global const uint *restrict places, __global uint *restrict queue_out)
{
    const uint count = counters[bounce].active;
#if SHADE_LANES
    struct scatter_run going;
    going.count = 0;
    SHADE_LANES_LOOP(i, count)
    {
        uint slots[LANES];
        const uint used = shade_lanes_slots(slots, queue, i, count);
        const lanes_float bits = LANES_WORD(lanes_float, paths, slots, .throughput_bits.w);
        const uint shaded = used & lanes_bits((lanes_as_uint(bits) & PATH_SHADED) != 0u);
        struct bsdf_lanes b;
        const uint together = bsdf_lanes_load(&b, slots, shaded, rays, paths, shades);
        scatter_eight(&going, settings, batch, bounce, slots, together, used & ~together, &b,
                      shades, rays, paths, points, places, counters, queue_out);
    }
    scatter_run_end(&going, counters, bounce, queue_out);
#else
    const uint i = get_global_id(0);
    if (i < count)
        scatter_one(settings, batch, bounce, queue[i], shades, rays, paths, points, places,
                    counters, queue_out);
#endif
}
