/**
 * @file
 * The light BVH: a hierarchy over lights that is walked by estimated contribution.
 *
 * Source: A. Conty Estevez, C. Kulla, "Importance Sampling of Many Lights with Adaptive Tree
 * Splitting", PACMCGIT 1(2), 2018: bounds of position, orientation and power, built as
 * prep/light_cluster.h says.
 * Differs from it: nodes have 8 children, which are weighed at once with vectors of 8: a CPU walks
 * a level for the price of one child, fewer levels mean fewer decisions by coarse bounds, and a
 * child's bounds stand in its parent. Bounds know the lights' range, so that what cannot reach the
 * point is never drawn. How it is walked: cl/lib/light_bvh.h.
 */
#ifndef PREP_LIGHT_BVH_H
#define PREP_LIGHT_BVH_H

#include <stdint.h>

#include "core/status.h"
#include "shared/light.h"

/** A built BVH. All zero is a valid one of no lights. */
struct light_bvh {
    struct light_bvh_node *nodes; // [node_count], root at 0; owned
    uint32_t *parents;            // [node_count] parent << 3 | child, or LIGHT_BVH_ROOT; owned
    uint32_t *leaves;             // [light_count] node << 3 | child of each light; owned
    uint32_t node_count;
    uint32_t light_count;
};

/**
 * Builds the BVH.
 *
 * @param lights  [light_count], borrowed.
 * @param shapes  Those that the lights point to, borrowed.
 * @param power   [light_count], borrowed; luminous power, lm, > 0: emitters.power.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status light_bvh_build(struct light_bvh *out, const struct light *lights,
                            const struct light_shape *shapes, const float *power,
                            uint32_t light_count);

void light_bvh_free(struct light_bvh *bvh);

#endif
