// Stage 7, scatter: the direction in which a path goes on from its shaded hit.
//
//   in    paths, rays, shades, queue of this bounce
//   out   paths, rays
//   next  compact
//
// Variants: those of lib/bsdf.h. With SHADE_LANES (lib/shade_lanes.h) eight paths go side by side
// where nothing but the Lambert term is left; on CPUs that is a kernel of its own only where no
// light is added, or forms are compared: else direct or directional sends paths on.

#include "lib/scatter.h"

#ifndef WG_SCATTER
#define WG_SCATTER (SHADE_LANES ? 1 : 64) // work items in a group
#endif

__kernel __attribute__((reqd_work_group_size(WG_SCATTER, 1, 1))) void scatter(
    __constant struct settings *settings, const struct batch batch, const uint bounce,
    __global const struct counters *counters, __global const uint *restrict queue,
    __global const struct shade *restrict shades, __global struct ray *restrict rays,
    __global struct path *restrict paths, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
    const uint count = counters[bounce].active;
#if SHADE_LANES
    SHADE_LANES_LOOP(i, count)
    {
        uint slots[LANES];
        uint rest = shade_lanes_slots(slots, queue, i, count);
        const uint lambert = rest & lambert_lanes_are(slots, PATH_SHADED | PATH_NO_BOUNCE,
                                                      PATH_SHADED, paths, shades);
        if (lambert != 0) {
            const struct lambert_lanes b = lambert_lanes_load(slots, rays, paths, shades);
            scatter_lanes(settings, batch, bounce, slots, lambert, &b, rays, paths, points, places);
        }
        for (rest &= ~lambert; rest != 0; rest &= rest - 1)
            scatter_slot(settings, batch, bounce, slots[lanes_lowest(rest)], shades, rays, paths,
                         points, places);
    }
#else
    const uint i = get_global_id(0);
    if (i < count)
        scatter_slot(settings, batch, bounce, queue[i], shades, rays, paths, points, places);
#endif
}
