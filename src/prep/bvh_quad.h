/**
 * @file
 * Turns the build tree into 4-wide nodes (shared/bvh_quad.h). Which subtrees become nodes and
 * leaves says prep/collapse.h.
 */
#ifndef PREP_BVH_QUAD_H
#define PREP_BVH_QUAD_H

#include "prep/bvh.h"
#include "scene/scene.h"
#include "shared/bvh_quad.h"

/** All zero is a valid empty one. */
struct quad_bvh {
    struct quad_node *nodes; // [node_count], depth first, root at 0; owned
    struct woop *woop;       // [ref_count]; owned
    uint32_t *refs;          // [ref_count], BVH_REF_...; owned
    uint32_t *places;        // [references of the tree] where each stands in refs; owned
    uint32_t node_count, ref_count;
};

/**
 * Makes the tree 4-wide. Boxes are rounded outwards to their grids, and by what kernels may lose. A
 * triangle that several references of a subtree name stands once in the leaf made of it.
 *
 * @param[out] out  Written on success only; release with quad_bvh_free(). Has a root at least.
 * @retval STATUS_LIMIT      The tree is deeper than BVH_STACK_SIZE, has more references than a
 * child word reaches, or is larger than a grid.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status quad_bvh_pack(struct quad_bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                          const struct geometry *geometry, const struct scene_material *materials);

void quad_bvh_free(struct quad_bvh *quad);

#endif
