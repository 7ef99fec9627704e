// Stage 1, raygen: one camera ray for each path of the batch, in Z-order.
//
//   in    camera, batch, points, places
//   out   rays, paths, queue[0 .. batch.count), counters of all bounces
//   next  trace
//
// With SHADE_LANES (lib/shade_lanes.h) eight paths go side by side.

#include "lib/raygen_slot.h"
#include "lib/shade_lanes.h"
#if SHADE_LANES
#include "lib/raygen_lanes.h"
#endif

#ifndef WG_RAYGEN
#define WG_RAYGEN (SHADE_LANES ? 1 : 64) // work items in a group
#endif

// The counters of a bounce to start with, from those that the batch before has left; bounce 0 has
// every path of the batch.
static inline struct counters raygen_counters(const struct counters before,
                                              const struct batch batch, const uint bounce)
{
    struct counters out = before;
    out.rays += before.active;
    out.active = bounce == 0 ? batch.count : 0;
    out.trace_head = 0;
    out.direct_head = 0;
    out.directional_head = 0;
    return out;
}

#if SHADE_LANES

// Starts eight paths; those past the end of the batch are not written.
static inline void raygen_lanes(__constant struct settings *settings,
                                __constant struct camera *camera, const struct batch batch,
                                const uint first, __global struct ray *restrict rays,
                                __global struct path *restrict paths, __global uint *restrict queue,
                                __global const uint4 *restrict points,
                                __global const uint *restrict places)
{
    uint slots[LANES];
    const lanes_uint slot = first + lanes_as_uint(LANES_ORDER);
    const uint own = first + LANES <= batch.count ? LANES_ALL : (1u << (batch.count - first)) - 1u;
    lanes_store(slot, slots);
    struct lanes3 org, dir;
    raygen_lanes_rays(&org, &dir, settings, camera, lanes_place(batch, places, slot, 0), points);
    const lanes_float zero = (lanes_float)(0.0f);
    LANES_STORE(rays, slots, .org, own, lanes4_make(org, zero));
    LANES_STORE(rays, slots, .dir, own, lanes4_make(dir, (lanes_float)(FLT_MAX)));

    // Start the paths.
    for (uint k = 0; k < LANES; k++) {
        if (!(own & (1u << k)))
            break;
        paths[first + k].throughput_bits =
            (float4)(1.0f, 1.0f, 1.0f, as_float(PATH_ALIVE | PATH_SPECULAR));
        paths[first + k].radiance_normal = (float4)(0.0f);
        queue[first + k] = first + k;
    }
}

#endif

__kernel __attribute__((reqd_work_group_size(WG_RAYGEN, 1, 1))) void raygen(
    __constant struct settings *settings, __constant struct camera *camera,
    const struct batch batch, const uint bounce_count, __global struct ray *restrict rays,
    __global struct path *restrict paths, __global uint *restrict queue,
    __global struct counters *restrict counters, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
#if SHADE_LANES
    for (uint i = get_global_id(0); i < bounce_count; i += get_global_size(0))
        counters[i] = raygen_counters(counters[i], batch, i);
    SHADE_LANES_LOOP(first, batch.count)
    raygen_lanes(settings, camera, batch, first, rays, paths, queue, points, places);
#else
    const uint slot = get_global_id(0);
    if (slot < bounce_count)
        counters[slot] = raygen_counters(counters[slot], batch, slot);
    if (slot >= batch.count)
        return; // the launch is rounded up to whole groups

    raygen_slot(settings, camera, batch, slot, rays, paths, queue, points, places);
#endif
}
