#include "prep/object_split.h"

#include <float.h>
#include <stdbool.h>
#include <string.h>

// So few references are put in order: there would be more bins than references.
#define SORT_MAX 8u

// Keeps the overlap of a split's children with it.
static void set_overlap(struct object_split *split, const struct box *left, const struct box *right)
{
    struct box both = *left;
    box_intersect(&both, right);
    split->overlap = box_is_empty(&both) ? 0.0 : box_half_area(both.lo, both.hi);
}

// Finds the cheapest plane of one axis between the centers of a few boxes.
static void sort_axis(struct object_split *best, const struct box *boxes, uint32_t count, int axis)
{
    // Put them in order.
    const struct box *sorted[SORT_MAX] = {boxes};
    float centers[SORT_MAX];
    for (uint32_t i = 0; i < count; i++) {
        const float center = box_center(&boxes[i], axis);
        uint32_t place = i;
        for (; place > 0 && centers[place - 1] > center; place--) {
            centers[place] = centers[place - 1];
            sorted[place] = sorted[place - 1];
        }
        centers[place] = center;
        sorted[place] = &boxes[i];
    }

    // Look at all ways to part them, as bins_sweep() does.
    struct box right[SORT_MAX], left = *sorted[0];
    right[count - 1] = *sorted[count - 1];
    for (uint32_t i = count - 1; i > 1; i--) {
        right[i - 1] = right[i];
        box_unite(&right[i - 1], sorted[i - 1]);
    }
    for (uint32_t i = 1; i < count; i++) {
        const double cost = i * box_half_area(left.lo, left.hi) +
                            (count - i) * box_half_area(right[i].lo, right[i].hi);
        if (cost < best->cost && centers[i - 1] < centers[i]) {
            *best = (struct object_split){.axis = axis, .lo = centers[i], .cost = cost};
            set_overlap(best, &left, &right[i]);
        }
        box_unite(&left, sorted[i]);
    }
}

// Puts whole references into the bins that their centers are in.
static void bin_objects(struct bins bins[3], const struct grid *grid, const struct part_set *parts,
                        uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        const struct box *box = &parts->boxes[i];
        for (int axis = 0; axis < 3; axis++) {
            const int bin = bin_of(box_center(box, axis), grid->lo[axis], grid->scale[axis]);
            box_unite(&bins[axis].boxes[bin], box);
            bins[axis].begin[bin]++;
        }
    }
}

void object_split_find(struct object_split *out, const struct part_set *parts, uint32_t first,
                       uint32_t count, const struct box *centers)
{
    const struct box *boxes = parts->boxes + first;
    *out = (struct object_split){.axis = -1, .cost = DBL_MAX};
    if (count <= SORT_MAX) {
        for (int axis = 0; axis < 3; axis++)
            sort_axis(out, boxes, count, axis);
        return;
    }
    struct bins bins[3];
    struct grid grid = {{0.0f}, {0.0f}, {0.0f}};
    for (int axis = 0; axis < 3; axis++) {
        // With an extent of nothing, or too little for its inverse, all goes into bin 0.
        const float extent = centers->hi[axis] - centers->lo[axis];
        grid_set_axis(&grid, axis, centers->lo[axis], extent, extent > FLT_MIN * 32.0f);
    }
    bins_fill(bins, bin_objects, &grid, parts, first, count);
    for (int axis = 0; axis < 3; axis++) {
        struct sweep sweep;
        memcpy(bins[axis].end, bins[axis].begin, sizeof(bins[axis].end));
        bins_sweep(&sweep, &bins[axis]);
        if (!(sweep.cost < out->cost))
            continue;
        *out = (struct object_split){axis,       sweep.plane, grid.lo[axis], grid.scale[axis],
                                     sweep.cost, 0.0};
        set_overlap(out, &sweep.left, &sweep.right);
    }
}

// Whether a reference goes left.
static inline bool is_left(const struct object_split *split, const struct box *box)
{
    const float center = box_center(box, split->axis);
    return split->plane > 0 ? bin_of(center, split->lo, split->scale) < split->plane
                            : center < split->lo;
}

uint32_t object_split_apply(struct part_set *parts, uint32_t first, uint32_t count,
                            const struct object_split *split)
{
    uint32_t i = first;
    uint32_t end = first + count;
    while (i < end) {
        if (is_left(split, &parts->boxes[i]))
            i++;
        else
            boxes_swap(parts->boxes, parts->order, i, --end);
    }
    return i - first;
}
