/**
 * @file
 * What a tree costs rays, found by tracing some.
 *
 * The surface area heuristic (bvh_sah_cost()) counts lines through the whole scene. Rays end at the
 * nearest hit, and begin in the midst: of two trees, the one that is cheaper by that count visits
 * up to a fifth more nodes in levels of closed rooms. T. Aila, T. Karras, S. Laine, "On Quality
 * Metrics of Bounding Volume Hierarchies", HPG 2013, show the same.
 */
#ifndef PREP_BVH_TRIAL_H
#define PREP_BVH_TRIAL_H

#include "prep/bvh.h"
#include "prep/flatten.h"

/**
 * Traces rays that leave points of random triangles, as Lambert's law says, to their nearest hits.
 * The same rays for the same geometry, whatever the tree.
 *
 * @param[out] out  Nodes visited and triangles tested a ray, on average. 0 for the empty tree.
 * @param refs  What the tree was built of, as bvh->order counts.
 * @param geometry  Where their corners are; has a triangle if the tree has a node.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status bvh_trial(double *out, const struct bvh *bvh, const struct tri_ref *refs,
                      const struct geometry *geometry);

#endif
