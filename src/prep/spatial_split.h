/**
 * @file
 * Splits of an SBVH's node in space: a plane cuts the references that lie across it.
 *
 * Source: M. Stich, H. Friedrich, A. Dietrich, "Spatial Splits in Bounding Volume Hierarchies", HPG
 * 2009.
 */
#ifndef PREP_SPATIAL_SPLIT_H
#define PREP_SPATIAL_SPLIT_H

#include <stdint.h>

#include "prep/box.h"
#include "prep/sbvh_bins.h"

/** The cheapest plane found to cut references at. */
struct spatial_split {
    int axis;
    float at;               // m
    double cost;            // references times half surface, m2; DBL_MAX: none found
    struct box left, right; // of the sides
    uint32_t left_count, right_count;
};

/** Finds the cheapest plane for references [count] from `first` on within `bounds`. */
void spatial_split_find(struct spatial_split *out, const struct part_set *parts, uint32_t first,
                        uint32_t count, const struct box *bounds);

/**
 * Cuts parts at a plane, each as far as that is cheaper than to put it on one side whole.
 *
 * @param[out] new_count  Parts there are now: left ones first, right ones behind.
 * @param room            Places from `first` on.
 * @return How many are left.
 */
uint32_t spatial_split_apply(uint32_t *new_count, struct part_set *parts, uint32_t first,
                             uint32_t count, uint32_t room, const struct spatial_split *split);

#endif
