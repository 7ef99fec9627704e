/**
 * @file
 * The camera ray of one path. For cl/raygen.cl, and for cl/bounce.cl, whose first bounce begins
 * with it.
 */
#ifndef LIB_RAYGEN_SLOT_H
#define LIB_RAYGEN_SLOT_H

#include "lib/math.h"
#include "lib/samples.h"
#include "shared/camera.h"
#include "shared/path.h"
#include "shared/ray.h"
#include "shared/zorder.h"

// Starts the path of a slot.
static inline void raygen_slot(__constant struct settings *settings,
                               __constant struct camera *camera, const struct batch batch,
                               const uint slot, __global struct ray *restrict rays,
                               __global struct path *restrict paths, __global uint *restrict queue,
                               __global const uint4 *restrict points,
                               __global const uint *restrict places)
{
    // Pick a point inside the pixel: box filter, one pixel wide.
    const struct path_place place = samples_place(batch, places, slot);
    const uint2 at = zorder_place(place.pixel, camera->width, camera->height);
    const uint4 bits =
        samples_draw(settings, points, place.pixel, place.sample, 0, RNG_USE_CAMERA, 0);
    const float x = (float)at.x + rng_unit(bits.y);
    const float y = (float)at.y + rng_unit(bits.z);

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

#endif
