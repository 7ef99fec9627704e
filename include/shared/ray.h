/**
 * @file
 * Rays and what they hit.
 */
#ifndef SHARED_RAY_H
#define SHARED_RAY_H

#include "shared/base.h"

#define HIT_NONE 0xffffffffu // hit.triangle of a ray that left the scene

#define RAY_PACKET 16u // camera rays that CPUs trace together

// One ray, world space. Two rows, so a kernel reads it in two loads. A ray with a span meets what
// lies between w and w. Those of paths meet what lies ahead, and carry there what is the path's:
//   org.w  bits of the geometric normal where it starts, viewer's side, oct_pack(); from material
//   dir.w  density with which this direction was chosen, 1/sr; from scatter
// While a hit is shaded, org is where rays leave it, and dir comes from the viewer.
struct ray {
    float4 org; // xyz origin, m; w nearest hit accepted, m
    float4 dir; // xyz unit direction; w farthest hit accepted, m
};
SHARED_SIZE(ray, 32);

// The nearest hit of one ray.
struct SHARED_ROW hit {
    float t;       // distance along the ray, m
    float u;       // weight of the triangle's second vertex
    float v;       // weight of the third; the first has 1 - u - v
    uint triangle; // index into triangles, or HIT_NONE
};
SHARED_SIZE(hit, 16);

#endif
