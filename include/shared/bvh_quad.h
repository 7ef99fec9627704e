/**
 * @file
 * The 4-wide BVH as GPU kernels read it: four boxes in the 64 bytes that two take in the binary
 * one, as bytes on a grid of the node's own.
 *
 * Source of the grid: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs
 * Through Compressed Wide BVHs", HPG 2017. Differs from it: four children, with a word each instead
 * of an order by octants; cells of any size.
 *
 *                0         1         2         3
 *     grid       origin.x  origin.y  origin.z  scale.x
 *     planes[0]  x 0-1     x 2-3     y 0-1     y 2-3      of the children
 *     planes[1]  z 0-1     z 2-3     scale.y   scale.z    bits of floats
 *     words      child 0   child 1   child 2   child 3
 *
 * A word of planes is, from its lowest byte on, lo and hi of one child and lo and hi of the next. A
 * plane lies at origin + scale * (1 + byte * 2^-BYTE_PLANE_SHIFT), m (shared/byte_planes.h).
 *
 * A child word is that of the binary BVH (shared/bvh.h), but names a quad_node if it is >= 0.
 * Children that are not there stand last; their boxes end before they begin, and their words are
 * leaves of no references. A search for any hit takes children in this order.
 */
#ifndef SHARED_BVH_QUAD_H
#define SHARED_BVH_QUAD_H

#include "shared/base.h"
#include "shared/bvh.h"
#include "shared/byte_planes.h"

#define QUAD_CHILDREN 4u
#define QUAD_EMPTY    (~0) // word of no child

// Entries of a traversal stack: each level of a tree shallower than BVH_STACK_SIZE, before it is
// made wide, leaves at most three.
#define QUAD_STACK_SIZE (3u * BVH_STACK_SIZE)

struct quad_node {
    float4 grid;
    uint4 planes[2];
    uint4 words;
};
SHARED_SIZE(quad_node, 64);

#endif
