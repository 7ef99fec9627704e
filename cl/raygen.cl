// Stage 1, raygen: one camera ray for each path of the batch, in Z-order.
//
//   in    camera, batch, points, places
//   out   rays, paths, queue[0 .. batch.count), counters of all bounces
//   next  trace
//
// With SHADE_LANES (lib/shade_lanes.h) eight paths go side by side.

#include "lib/raygen_slot.h"
#include "lib/shade_lanes.h"

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
    const uint8 slot = first + (uint8)(0, 1, 2, 3, 4, 5, 6, 7);
    const uint own = first + LANES <= batch.count ? 0xffu : (1u << (batch.count - first)) - 1u;
    vstore8(slot, 0, slots);

    // Pick points inside the pixels: box filter, one pixel wide.
    const struct lanes_place place = lanes_place(batch, places, slot);
    uint pixel[LANES];
    vstore8(place.pixel, 0, pixel);
    float8 columns, rows;
    for (uint k = 0; k < LANES; k++) {
        if (k != 0 && pixel[k] == pixel[k - 1])
            continue; // samples of a pixel are side by side
        const uint2 at = zorder_place(pixel[k], camera->width, camera->height);
        const int8 from_here = (int8)(0, 1, 2, 3, 4, 5, 6, 7) >= (int8)(int)k;
        columns = from_here ? (float8)((float)at.x) : columns;
        rows = from_here ? (float8)((float)at.y) : rows;
    }
    const struct lanes_numbers numbers =
        lanes_draw(settings, points, place.pixel, place.sample, 0, RNG_USE_CAMERA, (uint8)(0u));
    const float8 x = columns + lanes_unit(numbers.y);
    const float8 y = rows + lanes_unit(numbers.z);

    // Aim from the eye through them, or along the view from them.
    const struct lanes3 point = {camera->corner.x + x * camera->right.x + y * camera->down.x,
                                 camera->corner.y + x * camera->right.y + y * camera->down.y,
                                 camera->corner.z + x * camera->right.z + y * camera->down.z};
    const float4 eye = camera->org;
    const float4 forward = camera->forward;
    struct lanes3 org = {eye.x, eye.y, eye.z};
    struct lanes3 dir = {forward.x, forward.y, forward.z};
    if (camera->orthographic != 0)
        org = lanes3_add(org, point);
    else
        dir = lanes3_normalize(point);
    const float8 zero = (float8)(0.0f);
    LANES_STORE(rays, slots, .org, own, lanes4_make(org, zero));
    LANES_STORE(rays, slots, .dir, own, lanes4_make(dir, (float8)(FLT_MAX)));

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
