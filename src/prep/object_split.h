/**
 * @file
 * Splits of an SBVH's node by objects: each reference goes whole to the side that its center is on.
 */
#ifndef PREP_OBJECT_SPLIT_H
#define PREP_OBJECT_SPLIT_H

#include <stdint.h>

#include "prep/box.h"
#include "prep/sbvh_bins.h"

/** The cheapest way found to deal out whole references by their centers. */
struct object_split {
    int axis;       // -1: no plane parts the centers
    int plane;      // references with a bin below go left; 0: those with their center below lo
    float lo;       // of the centers on the axis
    float scale;    // bins a metre
    double cost;    // references times half surface, m2; DBL_MAX with axis -1
    double overlap; // half surface of what both sides share, m2
};

/** Finds the cheapest split of references [count] from `first` on; `centers` bounds their centers.
 */
void object_split_find(struct object_split *out, const struct part_set *parts, uint32_t first,
                       uint32_t count, const struct box *centers);

/** Reorders parts. Returns how many went left. */
uint32_t object_split_apply(struct part_set *parts, uint32_t first, uint32_t count,
                            const struct object_split *split);

#endif
