/**
 * @file
 * Triangles that have stopped a work item's last rays for any hit: they are likely to stop the next
 * ones as well, which then need no traversal. Those that let some light by are not kept.
 *
 * Source: E. Haines, D. Greenberg, "The Light Buffer: A Shadow-Testing Accelerator", IEEE CG&A
 * 1986: the last occluder is tried first. Differs from it: sixteen are at once, whatever the light,
 * and only while that pays.
 *
 * No answer depends on what is kept, so bits stay the same whoever traces which rays. Where float
 * is unsure, a ray may meet a triangle's end and yet pass its leaf's box, and a traversal finds
 * nothing. A triangle therefore counts only together with that box, by the traversal's arithmetic;
 * boxes of the nodes above contain it, so the traversal would get there.
 */
#ifndef LIB_OCCLUDERS_H
#define LIB_OCCLUDERS_H

#include "lib/eight.h"
#include "lib/math.h"
#include "shared/bvh_wide.h"

// Triangles that are kept. Of the rays that are stopped on the way from what a camera sees in
// Sponza to the sun, the last triangle stops 78 %, one of four 89 %, one of sixteen 93 %; on the
// way to one of 420 lights, 6, 20 and 51 %. Later bounces have 3 to 8, 10 to 20 and 22 to 37 %.
#define OCCLUDERS 16u

#define OCCLUDERS_ROWS 18u
#define OCCLUDERS_WOOP 6u // the first of the Woop rows

// When it pays: a test costs a quarter of the traversal that it may save. Tests go on while a sum
// stays above 0; then rays go without for a while.
#define OCCLUDERS_GAIN  4u   // to the sum for a ray stopped; 1 is lost for another one
#define OCCLUDERS_MOST  64u  // the largest sum
#define OCCLUDERS_TRIAL 16u  // the sum at the beginning, and after a pause
#define OCCLUDERS_PAUSE 320u // rays that go without

#define OCCLUDERS_NOWHERE 1e17f // m; boxes of none begin there and end at its negative

struct occluders {
    // Rows 0 .. 5: the box of each triangle's leaf, as in struct wide_node; from OCCLUDERS_WOOP on
    // its own as in struct woop_block.
    float rows[OCCLUDERS_ROWS][OCCLUDERS] __attribute__((aligned(64)));
    uint next;  // place of the next one, modulo OCCLUDERS
    uint worth; // the sum
    uint pause; // rays that go without from now on
};

static inline void occluders_begin(struct occluders *kept)
{
    const float16 nowhere = (float16)(OCCLUDERS_NOWHERE);
    for (uint r = 0; r < OCCLUDERS_WOOP; r++)
        vstore16((r & 1u) != 0 ? -nowhere : nowhere, 0, kept->rows[r]);
    for (uint r = OCCLUDERS_WOOP; r < OCCLUDERS_ROWS; r++)
        vstore16((float16)(0.0f), 0, kept->rows[r]);
    kept->next = 0;
    kept->worth = OCCLUDERS_TRIAL;
    kept->pause = 0;
}

// Keeps a triangle.
//
//   box   first of its leaf's values in a wide node
//   woop  first of its own values in a block
static inline void occluders_keep(struct occluders *kept, __global const float *box,
                                  __global const float *woop)
{
    if (kept->pause != 0)
        return;
    // Stores one by one: a scatter, which the compiler would make of them, is slower.
    volatile float *out = &kept->rows[0][kept->next++ % OCCLUDERS];
#pragma unroll
    for (uint r = 0; r < OCCLUDERS_WOOP; r++)
        out[r * OCCLUDERS] = box[r * WIDE_CHILDREN];
#pragma unroll
    for (uint r = OCCLUDERS_WOOP; r < OCCLUDERS_ROWS; r++)
        out[r * OCCLUDERS] = woop[(r - OCCLUDERS_WOOP) * WIDE_BLOCK];
}

// Bits of the triangles kept that the ray meets. The arithmetic is that of lib/traverse_wide.h, bit
// by bit.
//
//   inverse, shift  of the slab test, lib/traced.h
static inline uint occluders_test(const struct occluders *kept, const float3 org, const float3 dir,
                                  const float3 inverse, const float3 shift, const float tmin,
                                  const float tmax)
{
#define OCCLUDERS_ROW(r) vload16(0, kept->rows[r])
    // Where the ray enters the leaves' boxes, and leaves them.
    const uint near_x = inverse.x < 0.0f ? 1 : 0;
    const uint near_y = inverse.y < 0.0f ? 3 : 2;
    const uint near_z = inverse.z < 0.0f ? 5 : 4;
    const float16 x0 = MULADD(OCCLUDERS_ROW(near_x), (float16)(inverse.x), (float16)(shift.x));
    const float16 y0 = MULADD(OCCLUDERS_ROW(near_y), (float16)(inverse.y), (float16)(shift.y));
    const float16 z0 = MULADD(OCCLUDERS_ROW(near_z), (float16)(inverse.z), (float16)(shift.z));
    const float16 x1 = MULADD(OCCLUDERS_ROW(near_x ^ 1), (float16)(inverse.x), (float16)(shift.x));
    const float16 y1 = MULADD(OCCLUDERS_ROW(near_y ^ 1), (float16)(inverse.y), (float16)(shift.y));
    const float16 z1 = MULADD(OCCLUDERS_ROW(near_z ^ 1), (float16)(inverse.z), (float16)(shift.z));
    const float16 enter = max16(max16(x0, y0), max16(z0, (float16)(tmin)));
    const float16 leave = min16(min16(x1, y1), min16(z1, (float16)(tmax)));

    // Where it meets the triangles' planes, and whether that is within them.
    const float16 org_w =
        MULADD(OCCLUDERS_ROW(6), (float16)(org.x),
               MULADD(OCCLUDERS_ROW(7), (float16)(org.y),
                      MULADD(OCCLUDERS_ROW(8), (float16)(org.z), OCCLUDERS_ROW(9))));
    const float16 dir_w =
        MULADD(OCCLUDERS_ROW(6), (float16)(dir.x),
               MULADD(OCCLUDERS_ROW(7), (float16)(dir.y), OCCLUDERS_ROW(8) * dir.z));
    const float16 t = -org_w / dir_w;
    const float16 x = MULADD(t, (float16)(dir.x), (float16)(org.x));
    const float16 y = MULADD(t, (float16)(dir.y), (float16)(org.y));
    const float16 z = MULADD(t, (float16)(dir.z), (float16)(org.z));
    const float16 u =
        MULADD(OCCLUDERS_ROW(10), x,
               MULADD(OCCLUDERS_ROW(11), y, MULADD(OCCLUDERS_ROW(12), z, OCCLUDERS_ROW(13))));
    const float16 v =
        MULADD(OCCLUDERS_ROW(14), x,
               MULADD(OCCLUDERS_ROW(15), y, MULADD(OCCLUDERS_ROW(16), z, OCCLUDERS_ROW(17))));
#undef OCCLUDERS_ROW
    return bits16((enter <= leave) & (t > tmin) & (t < tmax) & (u >= 0.0f) & (v >= 0.0f) &
                  (u + v <= 1.0f));
}

// Whether one of the triangles kept stops the ray. If none does, a traversal may.
static inline bool occluders_stop(struct occluders *kept, const float3 org, const float3 dir,
                                  const float3 inverse, const float3 shift, const float tmin,
                                  const float tmax)
{
    if (kept->pause != 0) {
        kept->pause--;
        return false;
    }
    if (occluders_test(kept, org, dir, inverse, shift, tmin, tmax) != 0) {
        kept->worth = min(kept->worth + OCCLUDERS_GAIN, OCCLUDERS_MOST);
        return true;
    }
    if (--kept->worth == 0) {
        kept->worth = OCCLUDERS_TRIAL;
        kept->pause = OCCLUDERS_PAUSE;
    }
    return false;
}

#endif
