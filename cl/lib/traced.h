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

// Where a work item traces many rays one after the other, those for any hit are tried against what
// has stopped the last ones (lib/occluders.h).
#define TRACED_KEEPS (DEVICE_CPU && BVH_WIDE && PERSISTENT)

// A scene but for the BVH's nodes.
struct traced {
    __global const float4 *woop; // rows of the leaves' struct woop, or struct woop_block
    __global const uint *refs;   // numbers of the triangles, BVH_REF_...
    struct surface surface;      // asked where a reference is BVH_REF_ALPHA
#if TRACED_KEEPS
    struct occluders *kept; // where any hit is looked for first
#endif
};

// A component that can be divided by.
static inline float traverse_safe(const float x)
{
    return fabs(x) < 1e-20f ? (x < 0.0f ? -1e-20f : 1e-20f) : x;
}

// Of a ray's direction, for slab tests: t = plane * inverse + shift, with shift = -org * inverse.
// Numbers that can be divided by need no care for the ends of the range.
static inline float3 traverse_inverse(const float3 dir)
{
    return native_recip((float3)(traverse_safe(dir.x), traverse_safe(dir.y), traverse_safe(dir.z)));
}

// Where a ray enters a box, the latest of where it enters the slabs and of tmin, 0 at least; and
// where it leaves it, the earliest of where it leaves the slabs and of tmax. It meets the box if it
// enters no later than it leaves.
//
// GPUs find the largest of three integers by one instruction, and of floats that are not negative,
// bits stand in the order of the values. A negative one is below them all: it never is where the
// ray enters, since tmin is larger, and where it leaves, any negative one says as well that the box
// lies behind. CPUs compare floats as fast.
#if DEVICE_CPU

static inline float slab_enter(const float x, const float y, const float z, const float tmin)
{
    return max2(max2(x, y), max2(z, tmin));
}

static inline float slab_leave(const float x, const float y, const float z, const float tmax)
{
    return min2(min2(x, y), min2(z, tmax));
}

#else

static inline float slab_enter(const float x, const float y, const float z, const float tmin)
{
    return as_float(max(max(max(as_int(x), as_int(y)), as_int(z)), as_int(tmin)));
}

static inline float slab_leave(const float x, const float y, const float z, const float tmax)
{
    return as_float(min(min(min(as_int(x), as_int(y)), as_int(z)), as_int(tmax)));
}

#endif

// Turns the number of a reference into that of its triangle: once for each ray, since it is a miss
// of the cache.
static inline struct hit traced_name(struct hit hit, const struct traced *scene)
{
    if (hit.triangle != HIT_NONE)
        hit.triangle = scene->refs[hit.triangle] & BVH_REF_TRIANGLE;
    return hit;
}

#endif
