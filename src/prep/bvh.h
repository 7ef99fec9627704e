/**
 * @file
 * The thesis's BVH: top-down, greedy, surface area heuristic sampled at 8 places per axis
 * (section 3.1).
 *
 * Source: I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007: bins
 * over the centroids. Differs from it: 8 candidate planes an axis, all three axes; a node becomes a
 * leaf only by count, as in the thesis, never by cost; where no plane separates the centroids, or
 * the tree would come near BVH_STACK_SIZE, the references are halved at the median of the longest
 * axis.
 */
#ifndef PREP_BVH_H
#define PREP_BVH_H

#include <stdint.h>

#include "core/status.h"
#include "prep/presplit.h"

/** One node of the build tree. */
struct bvh_build_node {
    float lo[3], hi[3];
    uint32_t left;  // inner: index of the left child, right is left + 1; leaf: first reference
    uint32_t count; // leaf: references; inner: 0
};

/** A built tree. All zero is a valid tree of nothing. */
struct bvh {
    struct bvh_build_node *nodes; // [node_count], root at 0; owned
    uint32_t *order; // [ref_count], leaves' references in order: indices into the tri_refs given;
                     // owned. A builder that splits may name one several times
    uint32_t node_count, ref_count;
    uint32_t depth; // nodes on the longest way down, below BVH_STACK_SIZE
};

/**
 * Builds the tree with all host threads. The result does not depend on their number.
 *
 * @param[out] out   Written on success only; release with bvh_free().
 * @param refs       [ref_count], borrowed; finite boxes. 0 references give the empty tree.
 * @param leaf_size  A node with fewer references becomes a leaf: 2 .. BVH_LEAF_MAX + 1.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status bvh_build(struct bvh *out, const struct tri_ref *refs, uint32_t ref_count,
                      uint32_t leaf_size);

/**
 * Makes a tree of a builder's nodes: copies them depth first, with the leaves' references in that
 * order.
 *
 * @param nodes  Root at 0, any holes between.
 * @param order  What the leaves' `left` counts in.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status bvh_take(struct bvh *out, const struct bvh_build_node *nodes, const uint32_t *order);

/** Expected cost of a random ray that meets the root: inner nodes visited times 1 plus references
 * tested times 1. 0 for the empty tree. */
double bvh_sah_cost(const struct bvh *bvh);

void bvh_free(struct bvh *bvh);

#endif
