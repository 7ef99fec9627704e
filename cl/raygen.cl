// Stage 1, raygen: one camera ray for each path of the batch, in Z-order.
//
//   in    camera, batch, points, places
//   out   rays, paths, queue[0 .. batch.count), counters of all bounces
//   next  trace

#include "lib/math.h"
#include "lib/samples.h"
#include "shared/camera.h"
#include "shared/path.h"
#include "shared/ray.h"
#include "shared/zorder.h"

#ifndef WG_RAYGEN
#define WG_RAYGEN 64 // work items in a group
#endif

__kernel __attribute__((reqd_work_group_size(WG_RAYGEN, 1, 1))) void raygen(
    __constant struct settings *settings, __constant struct camera *camera,
    const struct batch batch, const uint bounce_count, __global struct ray *restrict rays,
    __global struct path *restrict paths, __global uint *restrict queue,
    __global struct counters *restrict counters, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
    const uint slot = get_global_id(0);

    // Clear the counters; bounce 0 starts with every path of the batch.
    if (slot < bounce_count) {
        struct counters zero;
        zero.active = slot == 0 ? batch.count : 0;
        zero.trace_head = 0;
        zero.direct_head = 0;
        zero.directional_head = 0;
        zero.shadow_rays = 0;
        zero.directional_rays = 0;
        zero.pad0 = 0;
        zero.pad1 = 0;
        counters[slot] = zero;
    }
    if (slot >= batch.count)
        return; // the launch is rounded up to whole groups

    // Pick a point inside the pixel: box filter, one pixel wide.
    const struct path_place place = samples_place(batch, places, slot);
    const uint pixel = zorder_pixel(place.pixel, camera->width, camera->height);
    const uint4 bits =
        samples_draw(settings, points, place.pixel, place.sample, 0, RNG_USE_CAMERA, 0);
    const float x = (float)(pixel % camera->width) + rng_unit(bits.y);
    const float y = (float)(pixel / camera->width) + rng_unit(bits.z);

    // Aim from the eye through it, or along the view from it.
    const float3 point = camera->corner.xyz + x * camera->right.xyz + y * camera->down.xyz;
    const bool orthographic = camera->orthographic != 0;
    const float3 org = camera->org.xyz + (orthographic ? point : (float3)(0.0f));
    const float3 dir = orthographic ? camera->forward.xyz : normalize(point);
    rays[slot].org = (float4)(org, 0.0f);
    rays[slot].dir = (float4)(dir, FLT_MAX);

    // Start the path.
    paths[slot].throughput_bits = (float4)(1.0f, 1.0f, 1.0f, as_float(PATH_ALIVE | PATH_SPECULAR));
    paths[slot].radiance_normal = (float4)(0.0f);
    queue[slot] = slot;
}
