/**
 * @file
 * Turns the build tree into what CPU kernels read: 8-wide nodes and blocks of four triangles
 * (shared/bvh_wide.h). Which subtrees become nodes and leaves says prep/collapse.h.
 */
#ifndef PREP_BVH_WIDE_H
#define PREP_BVH_WIDE_H

#include "prep/bvh.h"
#include "scene/scene.h"
#include "shared/bvh_wide.h"

/** All zero is a valid empty one. */
struct wide_bvh {
    struct wide_node *nodes;   // [node_count], depth first, root at 0; owned
    struct woop_block *blocks; // [block_count]; owned
    uint32_t *refs;            // [4 block_count], BVH_REF_... or WIDE_NO_REF; owned
    uint32_t node_count, block_count;
};

/**
 * Makes the tree wide. A triangle that several references of a subtree name stands once in the leaf
 * made of it.
 *
 * @param[out] out  Written on success only; release with wide_bvh_free(). Has a root at least.
 * @retval STATUS_LIMIT      The tree is deeper than BVH_STACK_SIZE or has more references than a
 * child word reaches.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status wide_bvh_pack(struct wide_bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                          const struct geometry *geometry, const struct scene_material *materials);

void wide_bvh_free(struct wide_bvh *wide);

#endif
