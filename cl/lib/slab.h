/**
 * @file
 * Slab tests that count along the ray from tmin, 0, to a little past the best hit so far,
 * 1: on GPUs products are cut off at 0 and 1 for free, where there were two more comparisons a box,
 * and misses are told by a sum and a product. What binds an H100 in a traversal are the units that
 * compare and pick bits.
 */
#ifndef LIB_SLAB_H
#define LIB_SLAB_H

#include "lib/traced.h"
#include "lib/warp.h"

#define SLAB_BEYOND 1.0f // where the ray enters a box that it misses, or more

// Where boxes are looked for if a ray has no end, m: boxes at 1e-20 of it still have other numbers
// than their neighbours.
#define SLAB_FAR 1e18f

// How far past tmin a ray looks for boxes while its best hit is at t: a little more than to there,
// since of hits at one distance the first in the scene counts.
static inline float slab_reach(const float t, const float tmin)
{
    return MULADD(min2(t, SLAB_FAR), 1.00001f, 1e-18f) - tmin;
}

// a * b + c for a plane that the ray meets first: from 0 to 1, where that costs nothing.
static inline float slab_near(const float a, const float b, const float c)
{
#if WARP_VOTES
    return warp_muladd_unit(a, b, c);
#elif DEVICE_CPU
    return MULADD(a, b, c);
#else
    return clamp(MULADD(a, b, c), 0.0f, 1.0f);
#endif
}

// Where the ray enters a box, by where it meets its near and its far planes; SLAB_BEYOND or more if
// it misses it.
static inline float slab_enter_unit(const float near_x, const float near_y, const float near_z,
                                    const float far_x, const float far_y, const float far_z)
{
#if DEVICE_CPU
    const float enter = slab_enter(near_x, near_y, near_z, 0.0f);
    const float leave = slab_leave(far_x, far_y, far_z, 1.0f);
    return enter <= leave ? enter : SLAB_BEYOND;
#else
    // As in slab_enter(); all near planes are met at 0 at least.
    const float enter = as_float(max(max(as_int(near_x), as_int(near_y)), as_int(near_z)));
    const float leave = as_float(min(min(as_int(far_x), as_int(far_y)), as_int(far_z)));
#if WARP_VOTES
    // Of one that is missed, however narrowly, the difference times this is beyond 1.
    return MULADD(warp_sub_unit(enter, leave), 1e30f, enter);
#else
    return enter <= leave ? enter : SLAB_BEYOND;
#endif
#endif
}

#endif
