/**
 * @file
 * Rays side by side against all triangles of the 8-wide BVH's blocks (shared/bvh_wide.h):
 * where there are few, CPUs are faster so than one ray at a time through nodes, whichever way the
 * rays run.
 *
 * Distances and weights of hits are those of a leaf in lib/traverse_wide.h. Whether a point is in
 * a triangle is asked in two dimensions, a fifth less work, as in I. Wald's ray tracer (PhD thesis,
 * 2004, chapter 7), with planes sorted by the axis that is left out, so that it is a constant;
 * of hits at one distance the first in struct few counts.
 */
#ifndef LIB_TRAVERSE_FEW_H
#define LIB_TRAVERSE_FEW_H

#include "lib/lanes.h"
#include "lib/traverse_wide.h"

#define FEW_MOST    (WIDE_FEW_BLOCKS * WIDE_BLOCK) // triangles
#define FEW_NO_AXIS 3u // of what is no triangle, as blocks are filled up with, or is taken

// Planes that look along one axis most: first those of two triangles, as halves of quads share one,
// then those of one.
struct few_axis {
    uint plane;     // the first, in struct few
    uint pair_end;  // past the last of two triangles
    uint plane_end; // past the last
    uint triangle;  // the first plane's first
};

// What gives a triangle's weights of its second and third vertices at a point.
struct few_weights {
    float4 row_u, row_v;
};

// The triangles, a work item's own copy, without the blocks' empty lanes.
struct few {
    struct few_axis axes[3];
    uint count;                // of triangles
    float planes[FEW_MOST][4]; // row_w
    float inside[FEW_MOST][8]; // of triangles: u and v on their planes, few_project()
    struct few_weights weights[FEW_MOST];
    uint names[FEW_MOST]; // the triangles' numbers
};

// The nearest hits.
struct few_hits {
    lanes_float t;    // first the farthest accepted
    lanes_float u, v; // weights of the triangles' second and third vertices, if there is a hit
    lanes_uint place; // in struct few; HIT_NONE if there is none
};

// None yet, nearer than the farthest that are accepted.
static inline struct few_hits few_hits_begin(const lanes_float farthest)
{
    const struct few_hits out = {farthest, (lanes_float)(0.0f), (lanes_float)(0.0f),
                                 (lanes_uint)(HIT_NONE)};
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

// The axis along which a plane looks most.
static inline uint few_axis_of(const float4 row_w)
{
    const float4 size = fabs(row_w);
    const bool yz = size.y > size.x || size.z > size.x;
    return !yz ? 0 : size.z > size.y ? 2 : 1;
}

// A row of weights at points of a plane, by two of their coordinates: x those of the first of the
// other axes, y of the second, z a constant. Who knows where a point is along them knows all, and a
// test takes two products where three were.
static inline float4 few_project(const float4 row, const float4 row_w, const uint axis)
{
    const float share = axis == 0 ? row.x / row_w.x : axis == 1 ? row.y / row_w.y : row.z / row_w.z;
    const float4 rest = row - share * row_w;
    return axis == 0 ? rest.yzww : axis == 1 ? rest.xzww : rest.xyww;
}

// Adds a triangle of a plane.
static inline void few_add(struct few *few, __global const float4 *woop, __global const uint *refs,
                           const uint ref, const float4 row_w, const uint axis)
{
    const float4 row_u = few_row(woop, ref, 1);
    const float4 row_v = few_row(woop, ref, 2);
    const uint k = few->count++;
    few->weights[k].row_u = row_u;
    few->weights[k].row_v = row_v;
    vstore4(few_project(row_u, row_w, axis), 0, few->inside[k]);
    vstore4(few_project(row_v, row_w, axis), 1, few->inside[k]);
    few->names[k] = refs[ref] & BVH_REF_TRIANGLE;
}

// Gathers the triangles of blocks.
static inline void few_begin(struct few *few, __global const float4 *woop,
                             __global const uint *refs, const uint block_count)
{
    const uint ref_count = block_count * WIDE_BLOCK;
    float4 rows[FEW_MOST];
    uint axis_of[FEW_MOST];
    for (uint ref = 0; ref < ref_count; ref++) {
        rows[ref] = few_row(woop, ref, 0);
        axis_of[ref] = refs[ref] != WIDE_NO_REF ? few_axis_of(rows[ref]) : FEW_NO_AXIS;
    }
    few->count = 0;
    uint plane = 0;
    for (uint axis = 0; axis < 3; axis++) {
        struct few_axis *looking = &few->axes[axis];
        looking->plane = plane;
        looking->triangle = few->count;
        for (uint a = 0; a < ref_count; a++)
            for (uint b = a + 1; b < ref_count && axis_of[a] == axis; b++)
                if (axis_of[b] == axis && few_share_plane(rows[a], rows[b])) {
                    vstore4(rows[a], 0, few->planes[plane++]);
                    few_add(few, woop, refs, a, rows[a], axis);
                    few_add(few, woop, refs, b, rows[b], axis);
                    axis_of[a] = axis_of[b] = FEW_NO_AXIS;
                }
        looking->pair_end = plane;
        for (uint ref = 0; ref < ref_count; ref++)
            if (axis_of[ref] == axis) {
                vstore4(rows[ref], 0, few->planes[plane++]);
                few_add(few, woop, refs, ref, rows[ref], axis);
            }
        looking->plane_end = plane;
    }
}

// Where rays meet a plane.
INLINED lanes_float few_meet(const float *row, const struct lanes3 org, const struct lanes3 dir)
{
    const lanes_float org_w =
        MULADD((lanes_float)row[0], org.x,
               MULADD((lanes_float)row[1], org.y,
                      MULADD((lanes_float)row[2], org.z, (lanes_float)row[3])));
    const lanes_float dir_w =
        MULADD((lanes_float)-row[0], dir.x, MULADD((lanes_float)-row[1], dir.y, -row[2] * dir.z));
    return org_w / dir_w;
}

// Weights at points.
static inline lanes_float few_weight(const struct lanes4 row, const struct lanes3 p)
{
    return MULADD(row.x, p.x, MULADD(row.y, p.y, MULADD(row.z, p.z, row.w)));
}

// Where in struct few the hits are; of rays without one, the first.
static inline void few_index(uint *place, const struct few_hits *hits)
{
    lanes_store(hits->place != HIT_NONE ? hits->place : (lanes_uint)(0u), place);
}

// Where rays are on a plane that looks along an axis, a constant: along the other two.
struct few_point {
    lanes_float first, second;
};

INLINED struct few_point few_point(const uint axis, const struct lanes3 org,
                                   const struct lanes3 dir, const lanes_float t)
{
    struct few_point out;
    out.first = axis == 0 ? MULADD(dir.y, t, org.y) : MULADD(dir.x, t, org.x);
    out.second = axis == 2 ? MULADD(dir.y, t, org.y) : MULADD(dir.z, t, org.z);
    return out;
}

static inline lanes_float few_weight_at(const float *row, const struct few_point p)
{
    return MULADD((lanes_float)row[0], p.first,
                  MULADD((lanes_float)row[1], p.second, (lanes_float)row[2]));
}

// How far points of its plane are within a triangle: the least of their weights, which is not
// negative there.
INLINED lanes_float few_depth(const struct few *few, const uint k, const struct few_point p)
{
    const lanes_float u = few_weight_at(few->inside[k], p);
    const lanes_float v = few_weight_at(few->inside[k] + 4, p);
    return lanes_min(lanes_min(u, v), 1.0f - (u + v));
}

// traverse_few() of the planes that look along one axis, a constant.
INLINED void few_traverse_axis(struct few_hits *hits, const struct few *few, const uint axis,
                               const struct lanes3 org, const struct lanes3 dir,
                               const lanes_float tmin, const bool alike)
{
    const struct few_axis looking = few->axes[axis];
    uint k = looking.triangle;
    for (uint i = looking.plane; i < looking.pair_end; i++, k += 2) {
        const lanes_float t = few_meet(few->planes[i], org, dir);
        const lanes_int nearer = (t > tmin) & (t < hits->t);
        if (alike && lanes_bits(nearer) == 0)
            continue;
        const struct few_point p = few_point(axis, org, dir, t);
        const lanes_float first = few_depth(few, k, p);
        const lanes_float second = few_depth(few, k + 1, p);
        const lanes_int hit = nearer & (lanes_max(first, second) >= 0.0f);
        hits->t = hit ? t : hits->t;
        hits->place = hit ? (first < 0.0f ? (lanes_uint)(k + 1) : (lanes_uint)(k)) : hits->place;
    }
    for (uint i = looking.pair_end; i < looking.plane_end; i++, k++) {
        const lanes_float t = few_meet(few->planes[i], org, dir);
        const lanes_int nearer = (t > tmin) & (t < hits->t);
        const lanes_int hit = nearer & (few_depth(few, k, few_point(axis, org, dir, t)) >= 0.0f);
        hits->t = hit ? t : hits->t;
        hits->place = hit ? (lanes_uint)(k) : hits->place;
    }
}

// Finds the nearest hit of each ray beyond tmin.
//
//   alike  constant: the rays run alike, and planes behind what they all have hit are worth a
//   branch
INLINED void traverse_few(struct few_hits *hits, const struct few *few, const struct lanes3 org,
                          const struct lanes3 dir, const lanes_float tmin, const bool alike)
{
    few_traverse_axis(hits, few, 0, org, dir, tmin, alike);
    few_traverse_axis(hits, few, 1, org, dir, tmin, alike);
    few_traverse_axis(hits, few, 2, org, dir, tmin, alike);

    // The weights of those that were found, as all traversals compute them.
    const struct lanes3 p = lanes3_muladd(dir, hits->t, org);
    uint place[LANES];
    few_index(place, hits);
    hits->u = few_weight(LANES_OF(few->weights, place, .row_u), p);
    hits->v = few_weight(LANES_OF(few->weights, place, .row_v), p);
}

// traverse_few_any() of the planes that look along one axis, a constant.
INLINED lanes_int few_any_axis(const struct few *few, const uint axis, const struct lanes3 org,
                               const struct lanes3 dir, const lanes_float tmax)
{
    const struct few_axis looking = few->axes[axis];
    lanes_int any = (lanes_int)(0);
    uint k = looking.triangle;
    for (uint i = looking.plane; i < looking.pair_end; i++, k += 2) {
        const lanes_float t = few_meet(few->planes[i], org, dir);
        const lanes_int between = (t > 0.0f) & (t < tmax);
        if (lanes_bits(between) == 0)
            continue; // of walls about the scene it is never
        const struct few_point p = few_point(axis, org, dir, t);
        any |= between & (lanes_max(few_depth(few, k, p), few_depth(few, k + 1, p)) >= 0.0f);
    }
    for (uint i = looking.pair_end; i < looking.plane_end; i++, k++) {
        const lanes_float t = few_meet(few->planes[i], org, dir);
        const lanes_int between = (t > 0.0f) & (t < tmax);
        if (lanes_bits(between) != 0)
            any |= between & (few_depth(few, k, few_point(axis, org, dir, t)) >= 0.0f);
    }
    return any;
}

// Which rays hit something before tmax.
INLINED lanes_int traverse_few_any(const struct few *few, const struct lanes3 org,
                                   const struct lanes3 dir, const lanes_float tmax)
{
    return few_any_axis(few, 0, org, dir, tmax) | few_any_axis(few, 1, org, dir, tmax) |
           few_any_axis(few, 2, org, dir, tmax);
}

// Hits as of struct hit.
static inline struct lanes4 few_name(const struct few_hits *hits, const struct few *few)
{
    uint place[LANES];
    few_index(place, hits);
    const lanes_int found = hits->place != HIT_NONE;
    const lanes_uint triangle = LANES_WORD(lanes_uint, few->names, place, );
    const struct lanes4 out = {hits->t, found ? hits->u : (lanes_float)(0.0f),
                               found ? hits->v : (lanes_float)(0.0f),
                               lanes_as_float(found ? triangle : (lanes_uint)(HIT_NONE))};
    return out;
}

#endif
