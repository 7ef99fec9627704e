/**
 * @file
 * Makes a tree better that a top-down builder has made: takes subtrees out and puts them back where
 * they enlarge boxes least.
 *
 * Source: D. Meister, J. Bittner, "Parallel Reinsertion for Bounding Volume Hierarchy
 * Optimization", CGF 37(2), 2018: in each round all subtrees look for their best places at once;
 * of moves that touch the same nodes, the one that gains most is made. Differs from it: a round
 * asks only the subtrees of the largest boxes, which gain most; moves are made in the order of
 * their gains, so that the tree does not depend on the number of threads.
 */
#ifndef PREP_BVH_REINSERT_H
#define PREP_BVH_REINSERT_H

#include "prep/bvh.h"
#include "prep/flatten.h"

/**
 * Makes the expected cost (bvh_sah_cost()) less, or leaves the tree as it is: also where rays, by
 * bvh_trial(), find the tree no cheaper than before. Leaves stay what they are, in another order.
 * The result does not depend on the number of threads.
 *
 * @param[in,out] bvh  Unchanged on failure.
 * @param refs         What the tree was built of, as bvh->order counts.
 * @param geometry     Where their corners are.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status bvh_reinsert(struct bvh *bvh, const struct tri_ref *refs,
                         const struct geometry *geometry);

#endif
