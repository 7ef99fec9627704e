/**
 * @file
 * The compressed 8-wide BVH: eight boxes in 80 bytes, for rays that run apart on GPUs.
 *
 * Source: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs", HPG 2017, section 3.2 and figure 3. Differs from it: the exponents are
 * those of cells times 2^BYTE_PLANE_SHIFT (shared/byte_planes.h says why); lower and upper planes
 * of an axis stand together.
 *
 *                0         1         2         3
 *     head       origin.x  origin.y  origin.z  exponents x, y, z, and a bit for each inner child
 *     links      nodes     refs      meta 0-3  meta 4-7
 *     planes[0]  lo.x 0-3  lo.x 4-7  hi.x 0-3  hi.x 4-7   a byte for each child, the first lowest
 *     planes[1]  lo.y 0-3  lo.y 4-7  hi.y 0-3  hi.y 4-7
 *     planes[2]  lo.z 0-3  lo.z 4-7  hi.z 0-3  hi.z 4-7
 *
 * A plane lies at origin + 2^(exponent - 127) * (1 + byte * 2^-BYTE_PLANE_SHIFT), m. `nodes` is the
 * first of the inner children's, which stand together in the order of their slots; `refs` the first
 * of the references of the node's leaves. References are those of the binary BVH (shared/bvh.h).
 *
 * A child stands in the slot, 0 .. 7, that best fits where it lies: a ray meets slots nearly in
 * order if it takes them by falling values of slot ^ k, where bit 0, 1 or 2 of k is set if it runs
 * towards +x, +y or +z. Meta says, as bits
 *
 *     0 0 0 0 0 0 0 0   no child; its box ends before it begins
 *     0 0 1 1 1 s s s   an inner child in slot s
 *     n n n f f f f f   a leaf of 1, 2 or 3 references: n = 001, 011, 111, from refs + f on
 *
 * so that a hit becomes bits of one word: (meta >> 5) << (meta & 31) for a leaf, and for an inner
 * child the same with its slot exchanged for slot ^ k.
 */
#ifndef SHARED_BVH_COMPRESSED_H
#define SHARED_BVH_COMPRESSED_H

#include "shared/base.h"
#include "shared/bvh.h"
#include "shared/byte_planes.h"

#define COMPRESSED_CHILDREN   8u
#define COMPRESSED_LEAF_REFS  3u          // most references of a leaf
#define COMPRESSED_INNER      0x38u       // meta of an inner child, its slot left out
#define COMPRESSED_INNER_HITS 0xff000000u // bits of a word of hits that are inner children's

// Entries of a traversal stack: each level of a tree shallower than BVH_STACK_SIZE, before it is
// made wide, leaves what is left of its node's children, and of its references; and a last one.
#define COMPRESSED_STACK_SIZE (2u * BVH_STACK_SIZE + 1u)

struct compressed_node {
    float4 head;
    uint4 links;
    uint4 planes[3];
};
SHARED_SIZE(compressed_node, 80);

#endif
