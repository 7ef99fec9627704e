/**
 * @file
 * Makes a tree's leaves smaller, for layouts that hold few references in each.
 */
#ifndef PREP_BVH_LEAVES_H
#define PREP_BVH_LEAVES_H

#include "prep/bvh.h"

/**
 * Copies a tree; leaves of more references are halved at the median of the longest axis until they
 * have no more than `most`.
 *
 * @param[out] out  Written on success only; release with bvh_free(). May be deeper than
 *                  BVH_STACK_SIZE.
 * @param refs      That the tree was built of.
 * @param most      1 at least.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status bvh_split_leaves(struct bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                             uint32_t most);

#endif
