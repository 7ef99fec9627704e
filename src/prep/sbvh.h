/**
 * @file
 * A BVH whose nodes may split triangles: fewer boxes overlap, so that rays visit less.
 *
 * Source: M. Stich, H. Friedrich, A. Dietrich, "Spatial Splits in Bounding Volume Hierarchies", HPG
 * 2009: binned object splits; where their children overlap by more than alpha of the root, binned
 * spatial splits with references clipped to both sides, and unsplitting. Differs from it: the
 * references that splits may add are an allowance, shared out from the root down in proportion to
 * the children's references (as Embree does), so that tasks need not talk to each other and the
 * tree does not depend on the number of threads; a few references are put in order instead of into
 * bins.
 */
#ifndef PREP_SBVH_H
#define PREP_SBVH_H

#include "prep/bvh.h"
#include "prep/flatten.h"

/**
 * Builds the tree with all host threads. The result does not depend on their number.
 *
 * @param[out] out   Written on success only; release with bvh_free(). Its order may name a
 * reference several times, by leaves whose boxes hold different parts of it.
 * @param refs       [ref_count], borrowed; finite boxes of parts of triangles.
 * @param geometry   Where the corners of refs[].triangle are.
 * @param leaf_size  No leaf has so many references: 2 .. BVH_LEAF_MAX + 1.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status sbvh_build(struct bvh *out, const struct tri_ref *refs, uint32_t ref_count,
                       const struct geometry *geometry, uint32_t leaf_size);

#endif
