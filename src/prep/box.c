#include "prep/box.h"

void boxes_bound(struct box *bounds, struct box *centers, const struct box *boxes, uint32_t count)
{
    *bounds = box_empty;
    *centers = box_empty;
    for (uint32_t i = 0; i < count; i++) {
        struct box center;
        for (int k = 0; k < 4; k++)
            center.lo[k] = center.hi[k] = box_center(&boxes[i], k);
        box_unite(bounds, &boxes[i]);
        box_unite(centers, &center);
    }
}

uint32_t boxes_halve(struct box *boxes, uint32_t *order, uint32_t count, const struct box *centers)
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (centers->hi[k] - centers->lo[k] > centers->hi[axis] - centers->lo[axis])
            axis = k;

    const int64_t median = count / 2;
    int64_t lo = 0;
    int64_t hi = (int64_t)count - 1;
    while (lo < hi) {
        const float pivot = box_center(&boxes[lo + (hi - lo) / 2], axis);
        int64_t i = lo;
        int64_t j = hi;
        while (i <= j) {
            while (box_center(&boxes[i], axis) < pivot)
                i++;
            while (box_center(&boxes[j], axis) > pivot)
                j--;
            if (i <= j)
                boxes_swap(boxes, order, i++, j--);
        }
        if (median <= j)
            hi = j;
        else if (median >= i)
            lo = i;
        else
            break; // all between equal the pivot
    }
    return count / 2;
}

uint32_t boxes_levels(uint32_t n)
{
    uint32_t levels = 0;
    while (levels < 32 && ((uint64_t)1 << levels) < n)
        levels++;
    return levels;
}
