/**
 * @file
 * Axis-aligned boxes in the making, and arrays of them that builders put in order.
 */
#ifndef PREP_BOX_H
#define PREP_BOX_H

#include <float.h>
#include <stdbool.h>
#include <stdint.h>

/** A box of four lanes, so that it is united by vector instructions; lane 3 stays 0. */
struct box {
    float lo[4], hi[4];
};

/** The box of nothing. */
static const struct box box_empty = {{FLT_MAX, FLT_MAX, FLT_MAX, 0.0f},
                                     {-FLT_MAX, -FLT_MAX, -FLT_MAX, 0.0f}};

/** Makes `box` hold `other`, too. */
static inline void box_unite(struct box *box, const struct box *other)
{
    for (int k = 0; k < 4; k++)
        box->lo[k] = other->lo[k] < box->lo[k] ? other->lo[k] : box->lo[k];
    for (int k = 0; k < 4; k++)
        box->hi[k] = other->hi[k] > box->hi[k] ? other->hi[k] : box->hi[k];
}

/** Leaves what is in `other`, too; maybe nothing, see box_is_empty(). */
static inline void box_intersect(struct box *box, const struct box *other)
{
    for (int k = 0; k < 4; k++)
        box->lo[k] = other->lo[k] > box->lo[k] ? other->lo[k] : box->lo[k];
    for (int k = 0; k < 4; k++)
        box->hi[k] = other->hi[k] < box->hi[k] ? other->hi[k] : box->hi[k];
}

static inline bool box_is_empty(const struct box *box)
{
    return box->lo[0] > box->hi[0] || box->lo[1] > box->hi[1] || box->lo[2] > box->hi[2];
}

/** Half the surface of lo[3], hi[3], in double, where the squares of all floats have room. */
static inline double box_half_area(const float *lo, const float *hi)
{
    const double x = (double)hi[0] - lo[0];
    const double y = (double)hi[1] - lo[1];
    const double z = (double)hi[2] - lo[2];
    return x * y + y * z + z * x;
}

static inline float box_center(const struct box *box, int axis)
{
    return 0.5f * box->lo[axis] + 0.5f * box->hi[axis];
}

/** Exchanges two boxes, and the numbers that belong to them. */
static inline void boxes_swap(struct box *boxes, uint32_t *order, int64_t i, int64_t j)
{
    const struct box box = boxes[i];
    boxes[i] = boxes[j];
    boxes[j] = box;
    const uint32_t number = order[i];
    order[i] = order[j];
    order[j] = number;
}

/** Bounds boxes [count], and their centers. */
void boxes_bound(struct box *bounds, struct box *centers, const struct box *boxes, uint32_t count);

/**
 * Reorders boxes [count] and the numbers that belong to them about the median of the longest axis
 * (quickselect).
 *
 * @param centers  Bounds of their centers.
 * @return How many went left: half.
 */
uint32_t boxes_halve(struct box *boxes, uint32_t *order, uint32_t count, const struct box *centers);

/** Levels that halving takes to part n boxes. */
uint32_t boxes_levels(uint32_t n);

#endif
