/**
 * @file
 * The binary BVH as kernels read it (thesis section 3.1 and 3.2; T. Aila, S. Laine, "Understanding
 * the Efficiency of Ray Traversal on GPUs", HPG 2009: both children's boxes stand in the parent, so
 * one visit tests both siblings).
 *
 * A child word c names a node if c >= 0. Otherwise ~c = first << BVH_LEAF_BITS | count names a
 * leaf: `count` references from `first` on. References stand in the order of the leaves; reference
 * i has its Woop rows at woop[i] and its triangle at refs[i].
 */
#ifndef SHARED_BVH_H
#define SHARED_BVH_H

#include "shared/base.h"

#define BVH_LEAF_BITS 5u  // bits of a leaf's count
#define BVH_LEAF_MAX  31u // most references in a leaf
#define BVH_STACK_SIZE                                                                             \
    64u // entries of a traversal stack; the builder keeps trees shallower than this

// refs[]: the triangle's index, and whether its material lets some rays by.
#define BVH_REF_ALPHA    0x80000000u
#define BVH_REF_TRIANGLE 0x7fffffffu

// One inner node: the boxes of its two children.
//
//   row0 = (c0.lo.x, c0.hi.x, c0.lo.y, c0.hi.y)
//   row1 = (c1.lo.x, c1.hi.x, c1.lo.y, c1.hi.y)
//   row2 = (c0.lo.z, c0.hi.z, c1.lo.z, c1.hi.z)
//   row3 = (bits of child word c0, bits of child word c1, 0, 0)
struct bvh_node {
    float4 row0, row1, row2, row3;
};
SHARED_SIZE(bvh_node, 64);

// The 3x4 matrix that takes a triangle to the unit triangle (0,0,0), (1,0,0), (0,1,0) (S. Woop, "A
// Ray Tracing Hardware Architecture for Dynamic Scenes", 2004). For a ray o + t d in world space
// and each row r: o' = r.xyz . o + r.w and d' = r.xyz . d. The rows stand in the order they are
// needed.
//
//   row_w: t = -o'w / d'w
//   row_u: u = o'u + t d'u, weight of the second vertex
//   row_v: v = o'v + t d'v, weight of the third vertex
//
// A degenerate triangle has all rows 0: t is NaN and no comparison holds, so it is never hit.
struct woop {
    float4 row_w, row_u, row_v;
};
SHARED_SIZE(woop, 48);

#endif
