/**
 * @file
 * Turns the build tree into compressed 8-wide nodes (shared/bvh_compressed.h). Which subtrees
 * become nodes and leaves says prep/collapse.h.
 */
#ifndef PREP_BVH_COMPRESSED_H
#define PREP_BVH_COMPRESSED_H

#include "prep/bvh.h"
#include "scene/scene.h"
#include "shared/bvh_compressed.h"

/** All zero is a valid empty one. */
struct compressed_bvh {
    struct compressed_node *nodes; // [node_count], root at 0; owned
    struct woop *woop;             // [ref_count]; owned
    uint32_t *refs;                // [ref_count], BVH_REF_...; owned
    uint32_t node_count, ref_count;
};

/**
 * Makes the tree 8-wide. Boxes are rounded outwards to their grids, and by what kernels may lose;
 * leaves of too many references are halved; a triangle that several references of a leaf name
 * stands there once. Children stand in the slots whose diagonals they lie farthest along, in sum
 * (Ylitie et al., section 3.2, solve that by an auction; eight slots are few enough to look at all
 * their subsets).
 *
 * @param[out] out  Written on success only; release with compressed_bvh_free(). Has a root at
 * least.
 * @retval STATUS_LIMIT      The tree is deeper than BVH_STACK_SIZE, has too many references, or is
 * larger than a grid.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status compressed_bvh_pack(struct compressed_bvh *out, const struct bvh *bvh,
                                const struct tri_ref *refs, const struct geometry *geometry,
                                const struct scene_material *materials);

void compressed_bvh_free(struct compressed_bvh *compressed);

#endif
