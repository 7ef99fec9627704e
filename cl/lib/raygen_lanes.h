/**
 * @file
 * The camera rays of paths side by side, on CPUs: for cl/raygen.cl and cl/paths.cl.
 */
#ifndef LIB_RAYGEN_LANES_H
#define LIB_RAYGEN_LANES_H

#include "lib/lanes.h"
#include "shared/camera.h"
#include "shared/zorder.h"

// As raygen_slot(), the rays; place is at bounce 0.
static inline void raygen_lanes_rays(struct lanes3 *org, struct lanes3 *dir,
                                     __constant struct settings *settings,
                                     __constant struct camera *camera,
                                     const struct lanes_place place,
                                     __global const uint4 *restrict points)
{
    // Pick points inside the pixels: box filter, one pixel wide.
    uint pixel[LANES];
    lanes_store(place.pixel, pixel);
    lanes_float columns, rows;
    for (uint k = 0; k < LANES; k++) {
        if (k != 0 && pixel[k] == pixel[k - 1])
            continue; // samples of a pixel are side by side
        const uint2 at = zorder_place(pixel[k], camera->width, camera->height);
        const lanes_int from_here = LANES_ORDER >= (lanes_int)(int)k;
        columns = from_here ? (lanes_float)((float)at.x) : columns;
        rows = from_here ? (lanes_float)((float)at.y) : rows;
    }
    const struct lanes_numbers numbers =
        lanes_draw(settings, points, place, place.sample, RNG_USE_CAMERA, (lanes_uint)(0u));
    const lanes_float x = columns + lanes_unit(numbers.y);
    const lanes_float y = rows + lanes_unit(numbers.z);

    // Aim from the eye through them, or along the view from them.
    const struct lanes3 point = {camera->corner.x + x * camera->right.x + y * camera->down.x,
                                 camera->corner.y + x * camera->right.y + y * camera->down.y,
                                 camera->corner.z + x * camera->right.z + y * camera->down.z};
    const float4 eye = camera->org;
    const float4 forward = camera->forward;
    *org = lanes3_make(eye.x, eye.y, eye.z);
    *dir = lanes3_make(forward.x, forward.y, forward.z);
    if (camera->orthographic != 0)
        *org = lanes3_add(*org, point);
    else
        *dir = lanes3_normalize(point);
}

#endif
