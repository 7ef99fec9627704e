/**
 * @file
 * Which subtrees of a binary tree become the children of wide nodes, and which become leaves: at
 * the least expected cost of a ray.
 *
 * Source: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs", HPG 2017, section 3.1. Differs from it: leaves cost by blocks of triangles
 * that are tested together; children stand in the order in which a search for any hit does best, an
 * idea of J.-H. Nah, D. Manocha, "SATO: Surface Area Traversal Order for Shadow Ray Tracing", CGF
 * 33(6), 2014.
 */
#ifndef PREP_COLLAPSE_H
#define PREP_COLLAPSE_H

#include <stdbool.h>

#include "prep/bvh.h"

#define COLLAPSE_WIDTH_MAX 8u

/** What a layout's nodes and leaves are. */
struct collapse_rule {
    uint32_t width;     // most children of a node: 2 .. COLLAPSE_WIDTH_MAX
    uint32_t block;     // triangles that are tested together
    uint32_t leaf_refs; // most references of subtrees that become a leaf; a leaf of the tree may
                        // have more
    float node_cost;    // of a visit of a node
    float block_cost;   // of a test of a block
};

/** What is known of a node of the tree. */
struct collapse_choice {
    float cost[COLLAPSE_WIDTH_MAX - 1]; // [width - 1] least cost of the subtree as at most 1, 2 ..
                                        // children of one wide node
    uint32_t first, count;              // its references, as bvh->order counts
    bool leaf;                          // as one child, it is a leaf
};

/** The choices for a tree. */
struct collapse {
    struct collapse_choice *choices; // [bvh->node_count]; owned
    const struct bvh *bvh;
    struct collapse_rule rule;
};

/**
 * Chooses for every node of a tree, which must outlive the result.
 *
 * @param[out] out  Written on success only; release with collapse_free().
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status collapse_build(struct collapse *out, const struct bvh *bvh,
                           const struct collapse_rule *rule);

/**
 * Finds the subtrees that become the children of a wide node, the most promising for any hit first.
 *
 * @param[out] children  [rule.width] nodes of the tree.
 * @param index          An inner node that is no leaf by choice.
 * @return Their number, 2 at least.
 */
uint32_t collapse_children(uint32_t *children, const struct collapse *collapse, uint32_t index);

/** Counts the wide nodes that the whole tree becomes; adds the blocks of its leaves to *blocks. */
uint32_t collapse_count(uint32_t *blocks, const struct collapse *collapse);

/** Blocks that so many references take. */
static inline uint32_t collapse_blocks(const struct collapse *collapse, uint32_t refs)
{
    return (refs + collapse->rule.block - 1) / collapse->rule.block;
}

void collapse_free(struct collapse *collapse);

#endif
