/**
 * @file
 * Eight rays against all triangles of the 8-wide BVH's blocks (shared/bvh_wide.h), side by side:
 * where there are few, CPUs are faster so than one ray at a time through nodes, whichever way the
 * rays run.
 *
 * The arithmetic is that of a leaf in lib/traverse_wide.h; of hits at one distance the first
 * reference counts.
 */
#ifndef LIB_TRAVERSE_FEW_H
#define LIB_TRAVERSE_FEW_H

#include "lib/lanes.h"
#include "lib/traverse_wide.h"

// The nearest hits of eight rays.
struct few_hits {
    float8 t;    // first the farthest accepted
    float8 u, v; // weights of the triangles' second and third vertices
    uint8 ref;   // their references; HIT_NONE if there is none
};

// Finds the nearest hit of each ray beyond tmin.
static inline void traverse_few(struct few_hits *hits, const struct traced *scene,
                                const uint block_count, const struct lanes3 org,
                                const struct lanes3 dir, const float8 tmin)
{
    for (uint ref = 0; ref < block_count * WIDE_BLOCK; ref++) {
        if (scene->refs[ref] == WIDE_NO_REF)
            continue; // blocks are filled up

        // Value r of the triangle's rows is row[4 r].
        __global const float *row = (__global const float *)scene->woop +
                                    (size_t)(ref / WIDE_BLOCK) * (4 * WIDE_BLOCK_ROWS) +
                                    ref % WIDE_BLOCK;

        // Where the rays meet its plane.
        const float8 org_w =
            MULADD((float8)row[0], org.x,
                   MULADD((float8)row[4], org.y, MULADD((float8)row[8], org.z, (float8)row[12])));
        const float8 dir_w =
            MULADD((float8)row[0], dir.x, MULADD((float8)row[4], dir.y, row[8] * dir.z));
        const float8 t = -org_w / dir_w;
        const int8 near = (t > tmin) & (t < hits->t);
        if (lanes_bits(near) == 0)
            continue;

        // And whether that is within the triangle.
        const struct lanes3 p = lanes3_muladd(dir, t, org);
        const float8 u =
            MULADD((float8)row[16], p.x,
                   MULADD((float8)row[20], p.y, MULADD((float8)row[24], p.z, (float8)row[28])));
        const float8 v =
            MULADD((float8)row[32], p.x,
                   MULADD((float8)row[36], p.y, MULADD((float8)row[40], p.z, (float8)row[44])));
        const int8 hit = near & (u >= 0.0f) & (v >= 0.0f) & (u + v <= 1.0f);
        hits->t = hit ? t : hits->t;
        hits->u = hit ? u : hits->u;
        hits->v = hit ? v : hits->v;
        hits->ref = hit ? (uint8)(ref) : hits->ref;
    }
}

#endif
