/**
 * @file
 * What rays visit of the binary BVH (shared/bvh.h), counted on the host: how hard they are to
 * trace, whatever traces them.
 */
#ifndef PREP_BVH_VISITS_H
#define PREP_BVH_VISITS_H

#include <stdbool.h>

#include "prep/bvh_pack.h"
#include "shared/ray.h"

/** Sums over rays. */
struct bvh_visits {
    uint64_t nodes;      // each with the boxes of two children
    uint64_t references; // tested
};

/**
 * Adds what a ray visits, as kernels do: the nearer child first, down to its nearest hit, or to any
 * hit.
 */
void bvh_count_visits(struct bvh_visits *sum, const struct packed_bvh *bvh, const struct ray *ray,
                      bool any_hit);

#endif
