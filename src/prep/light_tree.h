/**
 * @file
 * The light tree of thesis section 3.4 (shared/light.h): a hierarchy over the lights' affecting
 * spheres.
 *
 * Lights with a range are split top-down by the binary split, of all possible ones along each axis,
 * with the least sum of the two children's volumes; of equal ones the most even is taken. Lights
 * without one are halved along their longest axis into nodes with boundless boxes, whose children
 * are drawn by power. Where there are both kinds, the root has the first for its left child and the
 * second for its right.
 *
 * Differs from the thesis: among overlapping spheres the least sum cuts off one light at a time,
 * which makes a list. From the 16th level on, a split has to leave a quarter of the lights on each
 * side, so that no descent is longer than 17 + log(n) / log(4/3) steps.
 */
#ifndef PREP_LIGHT_TREE_H
#define PREP_LIGHT_TREE_H

#include <stdint.h>

#include "core/status.h"
#include "shared/light.h"

/** A built tree. All zero is a valid tree of no lights. */
struct light_tree {
    struct light_node *nodes; // [node_count], depth first, root at 0; owned
    uint32_t *parents;        // [node_count], parent's index, the root's is 0; owned
    uint32_t *leaves;         // [light_count], node of each light; owned
    uint32_t node_count;      // 2 * light_count - 1, or 0
    uint32_t light_count;
};

/**
 * Builds the tree. Probabilities of left children are 0.5 among lights with a range and between the
 * two kinds.
 *
 * @param[out] out  Written on success only; release with light_tree_free().
 * @param lights    [light_count], borrowed.
 * @param shapes    Those that the lights point to, borrowed.
 * @param power     [light_count], borrowed; > 0.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status light_tree_build(struct light_tree *out, const struct light *lights,
                             const struct light_shape *shapes, const float *power,
                             uint32_t light_count);

/**
 * The probability that a random descent at `point` ([3], m) ends in this light; 0 where it cannot.
 * The host's twin of the kernels' own.
 */
double light_tree_pmf(const struct light_tree *tree, const float *point, uint32_t light);

void light_tree_free(struct light_tree *tree);

#endif
