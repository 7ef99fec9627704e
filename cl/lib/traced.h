/**
 * @file
 * What rays are traced against, and the ray as slab tests want it: shared by all layouts of the
 * BVH.
 */
#ifndef LIB_TRACED_H
#define LIB_TRACED_H

#include "lib/passage.h"
#include "shared/bvh.h"
#include "shared/bvh_wide.h"
#include "shared/ray.h"

// A scene but for the BVH's nodes.
struct traced {
    __global const float4 *woop; // rows of the leaves' struct woop, or struct woop_block
    __global const uint *refs;   // numbers of the triangles, BVH_REF_...
    struct surface surface;      // asked where a reference is BVH_REF_ALPHA
};

// A component that can be divided by.
static inline float traverse_safe(const float x)
{
    return fabs(x) < 1e-20f ? (x < 0.0f ? -1e-20f : 1e-20f) : x;
}

// Of a ray's direction, for slab tests: t = plane * inverse + shift, with shift = -org * inverse.
static inline float3 traverse_inverse(const float3 dir)
{
    return 1.0f / (float3)(traverse_safe(dir.x), traverse_safe(dir.y), traverse_safe(dir.z));
}

#endif
