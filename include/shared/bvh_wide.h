/**
 * @file
 * The 8-wide BVH as CPU kernels read it: one visit tests eight boxes, one leaf test four triangles,
 * each by vector instructions over rows of equal coordinates.
 *
 * Source of the idea: I. Wald et al., "Embree: A Kernel Framework for Efficient CPU Ray Tracing",
 * SIGGRAPH 2014 (BVH8 with blocks of triangles). Differs from it: Woop's rows in the blocks.
 *
 * A child word c names a node if c >= 0. Otherwise ~c = first << WIDE_LEAF_BITS | count names a
 * leaf: `count` blocks from `first` on. Lane k of block b is reference 4 b + k: its triangle is at
 * refs[4 b + k]. Lanes past the leaf's last triangle have all rows 0, and no ray hits them.
 */
#ifndef SHARED_BVH_WIDE_H
#define SHARED_BVH_WIDE_H

#include "shared/base.h"
#include "shared/bvh.h"

#define WIDE_CHILDREN  8u
#define WIDE_BLOCK     4u          // triangles
#define WIDE_LEAF_BITS 4u          // bits of a leaf's count
#define WIDE_EMPTY     (~0)        // word of no child: a leaf of no blocks
#define WIDE_NO_REF    0xffffffffu // refs[] of a lane without a triangle

// Blocks of triangles that are few. On a CPU the bounces of a box of 32 triangles, in 13 blocks,
// take half of the time that they take through nodes; what eight rays at once need grows with the
// number of triangles, what each needs by itself hardly does.
#define WIDE_FEW_BLOCKS 16u

// Entries of a traversal stack: each level of a tree shallower than BVH_STACK_SIZE, before it is
// made wide, leaves at most seven.
#define WIDE_STACK_SIZE (7u * BVH_STACK_SIZE)

// One inner node: the boxes of its children. Row r is rows[2 r], rows[2 r + 1]; in each row stands
// one value of each child. A search for any hit takes children in this order.
//
//   rows 0, 1  lo.x, hi.x, m
//   rows 2, 3  lo.y, hi.y
//   rows 4, 5  lo.z, hi.z
//   row  6     bits of the child words
//   row  7     0: nodes are four cache lines
struct wide_node {
    float4 rows[16];
};
SHARED_SIZE(wide_node, 256);

// The Woop rows of four triangles (shared/bvh.h), a cache line each.
//
//   rows 0 .. 3   row_w.x, .y, .z, .w of the four
//   rows 4 .. 7   row_u
//   rows 8 .. 11  row_v
struct woop_block {
    float4 rows[12];
};
SHARED_SIZE(woop_block, 192);

#endif
