/**
 * @file
 * Eight rays against all triangles of the 8-wide BVH's blocks (shared/bvh_wide.h), side by side:
 * where there are few, CPUs are faster so than one ray at a time through nodes, whichever way the
 * rays run.
 *
 * The arithmetic is that of a leaf in lib/traverse_wide.h; of hits at one distance the first in
 * struct few counts.
 */
#ifndef LIB_TRAVERSE_FEW_H
#define LIB_TRAVERSE_FEW_H

#include "lib/lanes.h"
#include "lib/traverse_wide.h"

#define FEW_MOST (WIDE_FEW_BLOCKS * WIDE_BLOCK) // triangles

// The triangles, a work item's own copy, without the blocks' empty lanes. Where two lie in one
// plane, as halves of quads do, rays meet it once: first come `pair_count` planes of two triangles,
// plane i has 2 i and 2 i + 1, then planes of the others.
struct few {
    float planes[FEW_MOST][4];  // row_w
    float weights[FEW_MOST][8]; // row_u, row_v
    uint names[FEW_MOST];       // the triangles' numbers
    uint pair_count, count;     // planes of two; triangles
};

// The nearest hits of eight rays.
struct few_hits {
    float8 t;    // first the farthest accepted
    float8 u, v; // weights of the triangles' second and third vertices
    uint8 place; // in struct few; HIT_NONE if there is none
};

// None yet, nearer than the farthest that are accepted.
static inline struct few_hits few_hits_begin(const float8 farthest)
{
    const struct few_hits out = {farthest, (float8)(0.0f), (float8)(0.0f), (uint8)(HIT_NONE)};
    return out;
}

// A row of a triangle: of the blocks, the reference's lane of three rows.
static inline float4 few_row(__global const float4 *woop, const uint ref, const uint row)
{
    __global const float *first =
        (__global const float *)(woop + (size_t)(ref / WIDE_BLOCK) * WIDE_BLOCK_ROWS + 4 * row) +
        ref % WIDE_BLOCK;
    return (float4)(first[0], first[WIDE_BLOCK], first[2 * WIDE_BLOCK], first[3 * WIDE_BLOCK]);
}

// Whether triangles lie in one plane, whichever side they show. Quotients of its rows are the same.
static inline bool few_share_plane(const float4 a, const float4 b)
{
    return all(a == b) || all(a == -b);
}

// Adds a triangle of a plane that is there, or is to be the next.
static inline void few_add(struct few *few, __global const float4 *woop, __global const uint *refs,
                           const uint ref)
{
    vstore4(few_row(woop, ref, 1), 0, few->weights[few->count]);
    vstore4(few_row(woop, ref, 2), 1, few->weights[few->count]);
    few->names[few->count++] = refs[ref] & BVH_REF_TRIANGLE;
}

// Gathers the triangles of blocks.
static inline void few_begin(struct few *few, __global const float4 *woop,
                             __global const uint *refs, const uint block_count)
{
    const uint ref_count = block_count * WIDE_BLOCK;
    bool is_left[FEW_MOST];
    for (uint ref = 0; ref < ref_count; ref++)
        is_left[ref] = refs[ref] != WIDE_NO_REF; // blocks are filled up
    few->count = 0;
    for (uint a = 0; a < ref_count; a++)
        for (uint b = a + 1; b < ref_count && is_left[a]; b++)
            if (is_left[b] && few_share_plane(few_row(woop, a, 0), few_row(woop, b, 0))) {
                vstore4(few_row(woop, a, 0), 0, few->planes[few->count / 2]);
                few_add(few, woop, refs, a);
                few_add(few, woop, refs, b);
                is_left[a] = is_left[b] = false;
            }
    few->pair_count = few->count / 2;
    for (uint ref = 0; ref < ref_count; ref++)
        if (is_left[ref]) {
            vstore4(few_row(woop, ref, 0), 0, few->planes[few->count - few->pair_count]);
            few_add(few, woop, refs, ref);
        }
}

// Where rays meet a plane.
static inline float8 few_meet(const float *row, const struct lanes3 org, const struct lanes3 dir)
{
    const float8 org_w =
        MULADD((float8)row[0], org.x,
               MULADD((float8)row[1], org.y, MULADD((float8)row[2], org.z, (float8)row[3])));
    const float8 dir_w =
        MULADD((float8)row[0], dir.x, MULADD((float8)row[1], dir.y, row[2] * dir.z));
    return -org_w / dir_w;
}

// Of one row of weights, at points.
static inline float8 few_weight(const float *row, const struct lanes3 p)
{
    return MULADD((float8)row[0], p.x,
                  MULADD((float8)row[1], p.y, MULADD((float8)row[2], p.z, (float8)row[3])));
}

// Looks whether points of its plane are within a triangle.
static inline void few_take(struct few_hits *hits, const struct few *few, const uint k,
                            const struct lanes3 p, const float8 t)
{
    const float8 u = few_weight(few->weights[k], p);
    const float8 v = few_weight(few->weights[k] + 4, p);
    const int8 inside = (u >= 0.0f) & (v >= 0.0f) & (u + v <= 1.0f);
    // What was found so far is all that one triangle waits for of another, and is asked last.
    const float8 at = inside ? t : (float8)(FLT_MAX);
    const int8 hit = at < hits->t;
    hits->t = min8(at, hits->t);
    hits->u = hit ? u : hits->u;
    hits->v = hit ? v : hits->v;
    hits->place = hit ? (uint8)(k) : hits->place;
}

// Finds the nearest hit of each ray beyond tmin.
//
//   alike  constant: the rays run alike, and planes behind what they all have hit are worth a
//   branch
static inline void traverse_few(struct few_hits *hits, const struct few *few,
                                const struct lanes3 org, const struct lanes3 dir, const float8 tmin,
                                const bool alike)
{
    for (uint i = 0; i < few->pair_count; i++) {
        const float8 t = few_meet(few->planes[i], org, dir);
        const float8 ahead = t > tmin ? t : (float8)(FLT_MAX);
        if (alike && lanes_bits(ahead < hits->t) == 0)
            continue;
        const struct lanes3 p = lanes3_muladd(dir, t, org);
        few_take(hits, few, 2 * i, p, ahead);
        few_take(hits, few, 2 * i + 1, p, ahead);
    }
    for (uint k = 2 * few->pair_count; k < few->count; k++) {
        const float8 t = few_meet(few->planes[k - few->pair_count], org, dir);
        const float8 ahead = t > tmin ? t : (float8)(FLT_MAX);
        few_take(hits, few, k, lanes3_muladd(dir, t, org), ahead);
    }
}

// Which points of its plane are within a triangle.
static inline int8 few_holds(const struct few *few, const uint k, const struct lanes3 p)
{
    const float8 u = few_weight(few->weights[k], p);
    const float8 v = few_weight(few->weights[k] + 4, p);
    return (u >= 0.0f) & (v >= 0.0f) & (u + v <= 1.0f);
}

// Which rays hit something before tmax.
static inline int8 traverse_few_any(const struct few *few, const struct lanes3 org,
                                    const struct lanes3 dir, const float8 tmax)
{
    int8 any = (int8)(0);
    for (uint i = 0; i < few->pair_count; i++) {
        const float8 t = few_meet(few->planes[i], org, dir);
        const int8 between = (t > 0.0f) & (t < tmax);
        if (lanes_bits(between) == 0)
            continue; // of walls about the scene it is never
        const struct lanes3 p = lanes3_muladd(dir, t, org);
        any |= between & (few_holds(few, 2 * i, p) | few_holds(few, 2 * i + 1, p));
    }
    for (uint k = 2 * few->pair_count; k < few->count; k++) {
        const float8 t = few_meet(few->planes[k - few->pair_count], org, dir);
        const int8 between = (t > 0.0f) & (t < tmax);
        if (lanes_bits(between) != 0)
            any |= between & few_holds(few, k, lanes3_muladd(dir, t, org));
    }
    return any;
}

// Hits as of struct hit.
static inline struct lanes4 few_name(const struct few_hits *hits, const struct few *few)
{
    const int8 found = hits->place != HIT_NONE;
    uint place[LANES];
    vstore8(found ? hits->place : (uint8)(0u), 0, place);
    const uint8 triangle = LANES_WORD(uint8, few->names, place, );
    const struct lanes4 out = {hits->t, hits->u, hits->v,
                               as_float8(found ? triangle : (uint8)(HIT_NONE))};
    return out;
}

#endif
