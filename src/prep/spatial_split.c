#include "prep/spatial_split.h"

#include <float.h>
#include <stdbool.h>
#include <string.h>

#include "prep/vec3.h"

static void load_corners(double corners[3][3], const struct part_set *parts, uint32_t index)
{
    const struct geometry *geometry = parts->geometry;
    const struct triangle *triangle = &geometry->triangles[parts->refs[index].triangle];
    vec3_position(corners[0], &geometry->vertices[triangle->v0]);
    vec3_position(corners[1], &geometry->vertices[triangle->v1]);
    vec3_position(corners[2], &geometry->vertices[triangle->v2]);
}

// The same in floats, as boxes have them; lane 3 is 0.
static void load_corner_rows(float corners[3][4], const struct part_set *parts, uint32_t index)
{
    const struct geometry *geometry = parts->geometry;
    const struct triangle *triangle = &geometry->triangles[parts->refs[index].triangle];
    const uint32_t vertices[3] = {triangle->v0, triangle->v1, triangle->v2};
    for (int i = 0; i < 3; i++) {
        memcpy(corners[i], &geometry->vertices[vertices[i]].pos_normal, 3 * sizeof(float));
        corners[i][3] = 0.0f;
    }
}

static inline void unite_point(struct box *box, const double *p)
{
    for (int k = 0; k < 3; k++) {
        const float x = (float)p[k];
        box->lo[k] = x < box->lo[k] ? x : box->lo[k];
        box->hi[k] = x > box->hi[k] ? x : box->hi[k];
    }
}

// Bounds a part's two pieces on both sides of a plane (Stich et al., section 4.1). Coordinates are
// rounded to nearest: packing grows all boxes by more. One piece may be empty.
static void cut(struct box *left, struct box *right, const struct box *part, double corners[3][3],
                int axis, float at)
{
    *left = box_empty;
    *right = box_empty;
    for (int i = 0; i < 3; i++) {
        const double *a = corners[i];
        const double *b = corners[i < 2 ? i + 1 : 0];
        if (a[axis] <= at)
            unite_point(left, a);
        if (a[axis] >= at)
            unite_point(right, a);
        if ((a[axis] < at && b[axis] > at) || (a[axis] > at && b[axis] < at)) {
            double p[3];
            const double t = (at - a[axis]) / (b[axis] - a[axis]);
            for (int k = 0; k < 3; k++)
                p[k] = a[k] + t * (b[k] - a[k]);
            p[axis] = at;
            unite_point(left, p);
            unite_point(right, p);
        }
    }
    box_intersect(left, part);
    box_intersect(right, part);
}

// The slabs that one part reaches on an axis.
struct reach {
    struct box *slabs; // [first .. last] what of the part is in each
    const struct box *part;
    int axis, first, last;
    float lo, scale, width; // of the grid
};

static inline int slab_of(const struct reach *reach, float x)
{
    return bin_of(x, reach->lo, reach->scale);
}

// Puts a corner of a part into its slab, and where the edge from there to the next corner meets
// planes into the slabs on both sides. Rounded more than by cut(): what is found is an estimate.
static inline void bin_edge(const struct reach *reach, const float *a, const float *b)
{
    const int axis = reach->axis;
    const float lo = reach->part->lo[axis];
    const float hi = reach->part->hi[axis];
    struct box point;
    if (a[axis] >= lo && a[axis] <= hi) {
        memcpy(point.lo, a, sizeof(point.lo));
        memcpy(point.hi, a, sizeof(point.hi));
        box_unite(&reach->slabs[slab_of(reach, a[axis])], &point);
    }
    const float low = a[axis] < b[axis] ? a[axis] : b[axis];
    const float high = a[axis] < b[axis] ? b[axis] : a[axis];
    if (!(low < high && low < hi && high > lo))
        return;

    // Planes between slabs have two of them beside, those where the part ends have one.
    float slope[4];
    for (int k = 0; k < 4; k++)
        slope[k] = (b[k] - a[k]) / (b[axis] - a[axis]);
    const int from = low < lo ? reach->first - 1 : slab_of(reach, low);
    const int to = high > hi ? reach->last + 1 : slab_of(reach, high);
    for (int slab = from; slab < to; slab++) {
        const float at = slab < reach->first  ? lo
                         : slab < reach->last ? reach->lo + (float)(slab + 1) * reach->width
                                              : hi;
        for (int k = 0; k < 4; k++)
            point.lo[k] = point.hi[k] = a[k] + (at - a[axis]) * slope[k];
        box_unite(&reach->slabs[slab < reach->first ? reach->first : slab], &point);
        box_unite(&reach->slabs[slab < reach->last ? slab + 1 : reach->last], &point);
    }
}

// Chops one part into the slabs that it reaches: each holds the corners within, and where the edges
// meet its two planes.
static void chop_part(struct bins *bins, const struct grid *grid, const struct box *part,
                      float corners[3][4], int axis, int first, int last)
{
    struct box slabs[BIN_COUNT];
    const struct reach reach = {
        slabs, part, axis, first, last, grid->lo[axis], grid->scale[axis], grid->width[axis]};
    for (int slab = first; slab <= last; slab++)
        slabs[slab] = box_empty;
    for (int i = 0; i < 3; i++)
        bin_edge(&reach, corners[i], corners[i < 2 ? i + 1 : 0]);
    for (int slab = first; slab <= last; slab++) {
        box_intersect(&slabs[slab], part);
        if (!box_is_empty(&slabs[slab]))
            box_unite(&bins->boxes[slab], &slabs[slab]);
    }
}

// Puts what of references is in each slab into its bin.
static void bin_pieces(struct bins bins[3], const struct grid *grid, const struct part_set *parts,
                       uint32_t first, uint32_t count)
{
    for (uint32_t i = first; i < first + count; i++) {
        const struct box *part = &parts->boxes[i];
        int from[3], to[3];
        bool is_cut = false;
        for (int axis = 0; axis < 3; axis++) {
            from[axis] = bin_of(part->lo[axis], grid->lo[axis], grid->scale[axis]);
            to[axis] = bin_of(part->hi[axis], grid->lo[axis], grid->scale[axis]);
            bins[axis].begin[from[axis]]++;
            bins[axis].end[to[axis]]++;
            is_cut = is_cut || from[axis] != to[axis];
        }
        float corners[3][4];
        if (is_cut)
            load_corner_rows(corners, parts, parts->order[i]);
        for (int axis = 0; axis < 3; axis++) {
            if (from[axis] == to[axis])
                box_unite(&bins[axis].boxes[from[axis]], part);
            else
                chop_part(&bins[axis], grid, part, corners, axis, from[axis], to[axis]);
        }
    }
}

void spatial_split_find(struct spatial_split *out, const struct part_set *parts, uint32_t first,
                        uint32_t count, const struct box *bounds)
{
    struct bins bins[3];
    struct grid grid = {{0.0f}, {0.0f}, {0.0f}};
    for (int axis = 0; axis < 3; axis++) {
        const float lo = bounds->lo[axis];
        const float extent = bounds->hi[axis] - lo;
        const float width = extent / BIN_COUNT;
        // Else floats cannot tell the slabs apart.
        grid_set_axis(&grid, axis, lo, extent, width > FLT_MIN * 32.0f && lo + width > lo);
    }
    bins_fill(bins, bin_pieces, &grid, parts, first, count);
    *out = (struct spatial_split){.cost = DBL_MAX};
    for (int axis = 0; axis < 3; axis++) {
        struct sweep sweep;
        bins_sweep(&sweep, &bins[axis]);
        if (grid.scale[axis] == 0.0f || !(sweep.cost < out->cost))
            continue;
        *out = (struct spatial_split){axis,
                                      grid.lo[axis] + (float)sweep.plane * grid.width[axis],
                                      sweep.cost,
                                      sweep.left,
                                      sweep.right,
                                      sweep.left_count,
                                      sweep.right_count};
    }
}

// Half the surface of a box that holds another one, too.
static double united_area(const struct box *box, const struct box *other)
{
    struct box both = *box;
    box_unite(&both, other);
    return box_half_area(both.lo, both.hi);
}

enum side { SIDE_LEFT, SIDE_RIGHT, SIDE_BOTH };

// Decides where a part across the plane goes (Stich et al., section 4.4, reference unsplitting),
// and counts on with that.
static enum side place_part(struct spatial_split *s, const struct box *part)
{
    const double left_area = box_half_area(s->left.lo, s->left.hi);
    const double right_area = box_half_area(s->right.lo, s->right.hi);
    const double both = left_area * s->left_count + right_area * s->right_count;
    const double left =
        united_area(&s->left, part) * s->left_count + right_area * (s->right_count - 1.0);
    const double right =
        left_area * (s->left_count - 1.0) + united_area(&s->right, part) * s->right_count;
    if (both < left && both < right)
        return SIDE_BOTH;
    if (left < right) {
        box_unite(&s->left, part);
        s->right_count--;
        return SIDE_LEFT;
    }
    box_unite(&s->right, part);
    s->left_count--;
    return SIDE_RIGHT;
}

uint32_t spatial_split_apply(uint32_t *new_count, struct part_set *parts, uint32_t first,
                             uint32_t count, uint32_t room, const struct spatial_split *split)
{
    struct spatial_split s = *split;
    const int axis = s.axis;
    uint32_t i = first;
    uint32_t end = first + count; // where the right ones begin
    uint32_t top = end;           // past the last
    while (i < end) {
        struct box *box = &parts->boxes[i];
        enum side side = SIDE_BOTH;
        if (box->hi[axis] <= s.at)
            side = SIDE_LEFT;
        else if (box->lo[axis] >= s.at)
            side = SIDE_RIGHT;
        else
            side = place_part(&s, box);

        // Cut it, if there is room, and both sides get something.
        if (side == SIDE_BOTH) {
            double corners[3][3];
            struct box left, right;
            load_corners(corners, parts, parts->order[i]);
            cut(&left, &right, box, corners, axis, s.at);
            if (box_is_empty(&right)) {
                side = SIDE_LEFT;
            } else if (box_is_empty(&left) || top == first + room) {
                side = SIDE_RIGHT;
            } else {
                parts->boxes[top] = right;
                parts->order[top++] = parts->order[i];
                *box = left;
                side = SIDE_LEFT;
            }
        }
        if (side == SIDE_LEFT)
            i++;
        else
            boxes_swap(parts->boxes, parts->order, i, --end);
    }
    *new_count = top - first;
    return i - first;
}
