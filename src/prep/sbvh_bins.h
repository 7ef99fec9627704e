/**
 * @file
 * Parts of triangles, and the bins in which the splits of an SBVH's node count them: an axis is cut
 * into slabs of one width, and the planes between these are tried.
 *
 * Source: I. Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", RT 2007.
 * Differs from it: all axes are binned in one pass, and large nodes in shares.
 */
#ifndef PREP_SBVH_BINS_H
#define PREP_SBVH_BINS_H

#include <stdbool.h>
#include <stdint.h>

#include "prep/box.h"
#include "prep/flatten.h"
#include "prep/presplit.h"

#define BIN_COUNT 16 // slabs of an axis

/** Parts of triangles, in any order. */
struct part_set {
    struct box *boxes;               // of each part
    uint32_t *order;                 // which of refs[] each is a part of
    const struct tri_ref *refs;      // borrowed
    const struct geometry *geometry; // borrowed
};

/** Bins of one axis: the boxes of what is in each, how many begin there and how many end there. */
struct bins {
    struct box boxes[BIN_COUNT];
    uint32_t begin[BIN_COUNT], end[BIN_COUNT];
};

/** The bins of a node, on all axes. */
struct grid {
    float lo[4], scale[4]; // where they begin; bins a metre, 0 where there is only one
    float width[4];        // of one, m
};

/** The cheapest plane between bins. */
struct sweep {
    int plane; // 0: none; left are the bins below
    double cost;
    struct box left, right;
    uint32_t left_count, right_count;
};

/** Lays the bins of an axis over an extent, m; one bin for all where floats cannot tell more apart
 * (`separates`). */
void grid_set_axis(struct grid *grid, int axis, float lo, float extent, bool separates);

/** The bin of x, which is not below `lo`; the last one holds what is beyond, too. */
static inline int bin_of(float x, float lo, float scale)
{
    const float place = (x - lo) * scale; // NaN if the extent overflows
    return place < BIN_COUNT - 1 ? (int)place : BIN_COUNT - 1;
}

/** Adds references [count] from `first` on to the bins of all axes. */
typedef void bin_function(struct bins bins[3], const struct grid *grid,
                          const struct part_set *parts, uint32_t first, uint32_t count);

/** Puts a node's references into bins; what comes out does not depend on who does what. */
void bins_fill(struct bins bins[3], bin_function *fill, const struct grid *grid,
               const struct part_set *parts, uint32_t first, uint32_t count);

/** Finds the plane of one axis that costs least: references times half surface, of both sides. */
void bins_sweep(struct sweep *out, const struct bins *bins);

#endif
