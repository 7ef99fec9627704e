#include "prep/sbvh_bins.h"

#include <string.h>

// A node of so many references is looked at by several threads: there are few nodes yet to share
// out.
#define SHARE_REFS 32768u
#define SHARES     8u // parts of its references, each looked at by one

void grid_set_axis(struct grid *grid, int axis, float lo, float extent, bool separates)
{
    grid->lo[axis] = lo;
    grid->scale[axis] = separates ? BIN_COUNT / extent : 0.0f;
    grid->width[axis] = extent / BIN_COUNT;
}

static void clear_bins(struct bins bins[3])
{
    memset(bins, 0, 3 * sizeof(*bins));
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < BIN_COUNT; i++)
            bins[axis].boxes[i] = box_empty;
}

static void add_bins(struct bins bins[3], const struct bins more[3])
{
    for (int axis = 0; axis < 3; axis++)
        for (int i = 0; i < BIN_COUNT; i++) {
            box_unite(&bins[axis].boxes[i], &more[axis].boxes[i]);
            bins[axis].begin[i] += more[axis].begin[i];
            bins[axis].end[i] += more[axis].end[i];
        }
}

void bins_fill(struct bins bins[3], bin_function *fill, const struct grid *grid,
               const struct part_set *parts, uint32_t first, uint32_t count)
{
    clear_bins(bins);
    if (count < SHARE_REFS) {
        fill(bins, grid, parts, first, count);
        return;
    }
    struct bins shares[SHARES][3];
    const uint32_t most = (count + SHARES - 1) / SHARES;
#pragma omp taskgroup
    for (uint32_t i = 0; i < SHARES; i++) {
#pragma omp task shared(shares)
        {
            const uint32_t left = count - i * most;
            clear_bins(shares[i]);
            fill(shares[i], grid, parts, first + i * most, left < most ? left : most);
        }
    }
    for (uint32_t i = 0; i < SHARES; i++)
        add_bins(bins, shares[i]);
}

void bins_sweep(struct sweep *out, const struct bins *bins)
{
    // From the right: what lies at or beyond each plane.
    struct box right[BIN_COUNT];
    uint32_t right_counts[BIN_COUNT];
    struct box box = box_empty;
    uint32_t count = 0;
    for (int i = BIN_COUNT - 1; i > 0; i--) {
        box_unite(&box, &bins->boxes[i]);
        count += bins->end[i];
        right[i] = box;
        right_counts[i] = count;
    }

    // From the left: add the cost of all before it.
    *out = (struct sweep){.cost = DBL_MAX};
    box = box_empty;
    count = 0;
    for (int i = 1; i < BIN_COUNT; i++) {
        box_unite(&box, &bins->boxes[i - 1]);
        count += bins->begin[i - 1];
        if (count == 0 || right_counts[i] == 0 || box_is_empty(&box) || box_is_empty(&right[i]))
            continue; // the plane does not separate
        const double cost = count * box_half_area(box.lo, box.hi) +
                            right_counts[i] * box_half_area(right[i].lo, right[i].hi);
        if (cost < out->cost)
            *out = (struct sweep){i, cost, box, right[i], count, right_counts[i]};
    }
}
