/**
 * @file
 * Rays and what they hit.
 */
#ifndef SHARED_RAY_H
#define SHARED_RAY_H

#include "shared/base.h"

#define HIT_NONE 0xffffffffu // hit.triangle of a ray that left the scene

// One ray in flight, world space. Two rows, so a kernel reads it in two loads.
struct ray {
    float4 org_tmin; // xyz origin, m; w nearest hit accepted, m
    float4 dir_tmax; // xyz unit direction; w farthest hit accepted, m
};
SHARED_SIZE(ray, 32);

// The nearest hit of one ray.
struct hit {
    float t;       // distance along the ray, m
    float u;       // weight of the triangle's second vertex
    float v;       // weight of the third; the first has 1 - u - v
    uint triangle; // index into triangles, or HIT_NONE
};
SHARED_SIZE(hit, 16);

#endif
