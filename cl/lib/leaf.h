/**
 * @file
 * The test of a leaf's triangles, one after the other, and what waits for it: shared by the layouts
 * of GPUs.
 *
 * Source: S. Woop, "A Ray Tracing Hardware Architecture for Dynamic Scenes", 2004, as in T. Aila,
 * S. Laine, HPG 2009. Differs from it: a triangle whose material lets some light by is asked before
 * it counts as a hit (lib/passage.h). Whatever the layout, and whatever the order of the tests, a
 * ray has the same hit, bit by bit: products are added as is written, which leaves a compiler no
 * choice, and of triangles at one distance the first in the scene is hit.
 */
#ifndef LIB_LEAF_H
#define LIB_LEAF_H

#include "lib/traced.h"
#include "lib/warp.h"

// With WARP_VOTES, leaves are put off until few lanes of the warp still look for one, where the
// paper's speculative traversal waits for the last of them; and the last lanes that have leaves to
// test keep them for the next time. More lanes are then busy at a node: over the 4-wide BVH, an
// H100 traces bounces in Sponza at 6 to 10 % more rays/s. Parts from a third to a sixth, and from a
// third to an eighth, are within 2 % of these. With a second leaf kept by each lane it is 2 to 4 %
// slower.
//
//   lanes  of the warp that walk, LEAF_LANES()
#if WARP_VOTES
#define LEAF_SEARCHERS           4u // few look for a leaf: one lane in
#define LEAF_TESTERS             4u // few test one: one lane in
#define LEAF_LANES()             warp_lanes()
#define LEAF_IS_DUE(leaf, lanes) (warp_count((leaf) == 0) * LEAF_SEARCHERS <= (lanes))
#define LEAF_MAY_WAIT(lanes)     (warp_lanes() * LEAF_TESTERS <= (lanes))
#else
#define LEAF_LANES()             1u
#define LEAF_IS_DUE(leaf, lanes) ((leaf) != 0)
#define LEAF_MAY_WAIT(lanes)     ((lanes) > 1)
#endif

// Where a point stands along a row, but for its last number, which is given.
static inline float leaf_along(const float4 row, const float3 p, const float w)
{
    return MULADD(row.x, p.x, MULADD(row.y, p.y, MULADD(row.z, p.z, w)));
}

// GPUs divide in half the instructions if the ends of the range need no care: a ray that runs along
// a triangle's plane does not meet it.
static inline float leaf_quotient(const float a, const float b)
{
#if DEVICE_CPU
    return a / b;
#else
    return a * native_recip(b);
#endif
}

// Whether, of a hit and of reference i at the same distance, the hit stays. One at the end of the
// ray is none.
static inline bool leaf_tie_stays(const struct hit *hit, const struct traced *scene, const uint i)
{
    return hit->triangle == HIT_NONE ||
           (scene->refs[hit->triangle] & BVH_REF_TRIANGLE) <= (scene->refs[i] & BVH_REF_TRIANGLE);
}

// Tests a reference. Returns whether the ray ends there.
//
//   hit   the best so far; its triangle is the number of a reference, see traced_name()
static inline bool leaf_test_one(struct hit *hit, const struct traced *scene, const uint i,
                                 const float3 org, const float3 dir, const float tmin,
                                 const bool any_hit, struct passage *passage, const int mode)
{
#if WARP_VOTES
    float4 row_w, row_u, row_v;
    warp_load_rows(&row_w, &row_u, &row_v, scene->woop + 3 * i);
#else
    const float4 row_w = scene->woop[3 * i + 0];
    const float4 row_u = scene->woop[3 * i + 1];
    const float4 row_v = scene->woop[3 * i + 2];
#endif
    const float t = -leaf_quotient(leaf_along(row_w, org, row_w.w), leaf_along(row_w, dir, 0.0f));
    if (!(t > tmin && (any_hit ? t < hit->t : t <= hit->t)))
        return false;
    if (!any_hit && t == hit->t && leaf_tie_stays(hit, scene, i))
        return false;
    const float3 p = MULADD((float3)(t), dir, org);
    const float u = leaf_along(row_u, p, row_u.w);
    if (!(u >= 0.0f && u <= 1.0f))
        return false;
    const float v = leaf_along(row_v, p, row_v.w);
    if (!(v >= 0.0f && u + v <= 1.0f))
        return false;
#if ALPHA
    const uint ref = scene->refs[i];
    if ((ref & BVH_REF_ALPHA) &&
        passage_ask(passage, mode, &scene->surface, ref & BVH_REF_TRIANGLE, u, v, org, dir))
        return false;
#endif
    hit->t = t;
    hit->u = u;
    hit->v = v;
    hit->triangle = i;
    return any_hit;
}

// Tests the first triangle of a leaf, by its word. Returns whether the ray ends there.
static inline bool leaf_test(struct hit *hit, const struct traced *scene, const int word,
                             const float3 org, const float3 dir, const float tmin,
                             const bool any_hit, struct passage *passage, const int mode)
{
    return ((uint)~word & BVH_LEAF_MAX) != 0 &&
           leaf_test_one(hit, scene, (uint)~word >> BVH_LEAF_BITS, org, dir, tmin, any_hit, passage,
                         mode);
}

// The word of a leaf without its first triangle; 0 if there is no other.
static inline int leaf_rest(const int word)
{
    const uint bits = (uint)~word;
    return (bits & BVH_LEAF_MAX) > 1 ? (int)~(bits + (1u << BVH_LEAF_BITS) - 1u) : 0;
}

#endif
