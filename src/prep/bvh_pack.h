/**
 * @file
 * Turns the build tree into what kernels read: 64-byte nodes, Woop rows and reference words
 * (shared/bvh.h).
 */
#ifndef PREP_BVH_PACK_H
#define PREP_BVH_PACK_H

#include <stdint.h>

#include "core/status.h"
#include "prep/bvh.h"
#include "scene/scene.h"
#include "shared/bvh.h"

/** All zero is a valid empty one. */
struct packed_bvh {
    struct bvh_node *nodes; // [node_count], depth first, root at 0; at least one: of no or few
                            // triangles, a root with empty leaves (boxes far away, 0 references);
                            // owned
    struct woop *woop;      // [ref_count]; owned. NULL: another layout's serve,
    uint32_t *refs;         // [ref_count], BVH_REF_...; owned. and its references
    uint32_t node_count, ref_count;
};

/**
 * Packs the tree depth first. Boxes are rounded outwards so that Woop's test never loses a hit at a
 * box's face.
 *
 * @retval STATUS_LIMIT      The tree is deeper than BVH_STACK_SIZE or has more references than a
 * child word reaches.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status bvh_pack(struct packed_bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                     const struct geometry *geometry, const struct scene_material *materials);

/**
 * Packs the nodes alone, over references that another layout has put in an order of its own.
 *
 * @param places  [bvh->ref_count] where each of the tree's stands there. Those of a leaf must be
 * next to each other but for some that stand further off among BVH_LEAF_MAX, for the same triangle
 * stands there once: then the leaf has all between, too, which costs a test and changes no hit.
 */
enum status bvh_pack_over(struct packed_bvh *out, const struct bvh *bvh, const uint32_t *places);

/** Makes the box of a node a little larger, so that Woop's test never loses a hit at its face. */
void bvh_grow(float *lo, float *hi, const struct bvh_build_node *node);

/** Computes the Woop rows of a triangle. */
void bvh_woop(struct woop *out, const struct geometry *geometry, uint32_t triangle);

/** A triangle's entry of refs[]. */
uint32_t bvh_ref_word(const struct geometry *geometry, const struct scene_material *materials,
                      uint32_t triangle);

/**
 * Writes the entries of refs[] for a leaf of wider trees, each triangle once.
 *
 * @param[out] words    [count] at most.
 * @param[out] places   [count] which of these stands for each reference; NULL: not asked for.
 * @param first, count  The leaf's references, as bvh->order counts.
 * @return How many were written.
 */
uint32_t bvh_ref_words(uint32_t *words, uint32_t *places, const struct bvh *bvh, uint32_t first,
                       uint32_t count, const struct tri_ref *refs, const struct geometry *geometry,
                       const struct scene_material *materials);

/** STATUS_LIMIT if child words and stacks do not reach over the tree. */
enum status bvh_check_limits(const struct bvh *bvh);

void packed_bvh_free(struct packed_bvh *packed);

#endif
