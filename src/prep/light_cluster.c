#include "prep/light_cluster.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/color.h"
#include "prep/vec3.h"

#define BIN_COUNT     12 // candidate planes of an axis, less one (pbrt 4ed section 12.6.3)
#define BIN_COUNT_FEW 4  // of sets with fewer lights than FEW: they are many, and planes cost
#define FEW           8
#define BALANCE_DEPTH 40   // levels after which sets are halved, so that depth stays bounded
#define TASK_LIGHTS   4096 // smaller subtrees are not worth a task
#define LINE_PART     1e-3 // of the squared diagonal, added to surfaces: lights in a row have none

#define FLAG_TWO_SIDED 1u
#define FLAG_ALL       2u // shines in all directions

// One light, as building reads it again and again.
struct item {
    float lo[3], hi[3];
    float axis[3]; // of two-sided lights, of both the one to a fixed side
    float cos_e;
    float power;
    float range;
    uint32_t flags;
    uint32_t light;
};

// What is gathered of a set in one pass.
struct gathered {
    float lo[3], hi[3];           // of positions
    float axis_lo[3], axis_hi[3]; // of axes
    float cos_e, range;
    double power;
    uint32_t flags, count;
};

struct builder {
    struct item *items; // [light_count], those of a node side by side
    struct light_cluster *nodes;
};

static const struct gathered nothing = {
    .lo = {FLT_MAX, FLT_MAX, FLT_MAX},
    .hi = {-FLT_MAX, -FLT_MAX, -FLT_MAX},
    .axis_lo = {1.0f, 1.0f, 1.0f},
    .axis_hi = {-1.0f, -1.0f, -1.0f},
    .cos_e = 1.0f,
};

static inline float least(float a, float b)
{
    return a < b ? a : b;
}

static inline float most(float a, float b)
{
    return a > b ? a : b;
}

static inline void gather(struct gathered *set, const struct item *item)
{
    for (int k = 0; k < 3; k++) {
        set->lo[k] = least(set->lo[k], item->lo[k]);
        set->hi[k] = most(set->hi[k], item->hi[k]);
        set->axis_lo[k] = least(set->axis_lo[k], item->axis[k]);
        set->axis_hi[k] = most(set->axis_hi[k], item->axis[k]);
    }
    set->cos_e = least(set->cos_e, item->cos_e);
    set->range = most(set->range, item->range);
    set->power += item->power;
    set->flags |= item->flags;
    set->count++;
}

static void unite(struct gathered *set, const struct gathered *other)
{
    for (int k = 0; k < 3; k++) {
        set->lo[k] = least(set->lo[k], other->lo[k]);
        set->hi[k] = most(set->hi[k], other->hi[k]);
        set->axis_lo[k] = least(set->axis_lo[k], other->axis_lo[k]);
        set->axis_hi[k] = most(set->axis_hi[k], other->axis_hi[k]);
    }
    set->cos_e = least(set->cos_e, other->cos_e);
    set->range = most(set->range, other->range);
    set->power += other->power;
    set->flags |= other->flags;
    set->count += other->count;
}

static inline float center(const struct item *item, int axis)
{
    return 0.5f * item->lo[axis] + 0.5f * item->hi[axis];
}

// ---- Single lights

// Fills in what a surface light is: where, and its axis.
static void set_surface(struct item *out, const struct light_shape *shape, uint32_t kind)
{
    const uint32_t type = kind & LIGHT_TYPE_MASK;
    const float u[3] = {shape->edge_u.x, shape->edge_u.y, shape->edge_u.z};
    const float v[3] = {shape->edge_v.x, shape->edge_v.y, shape->edge_v.z};
    double du[3], dv[3], normal[3];
    vec3_load(du, u);
    vec3_load(dv, v);
    vec3_cross(normal, du, dv);
    const double length = vec3_length(normal);
    for (int k = 0; k < 3; k++) {
        if (type == LIGHT_DISC) {
            const float reach = float_above(sqrt(du[k] * du[k] + dv[k] * dv[k]));
            out->lo[k] -= reach;
            out->hi[k] += reach;
        } else {
            const float far = type == LIGHT_RECTANGLE ? u[k] + v[k] : u[k];
            out->lo[k] += least(least(0.0f, far), least(u[k], v[k]));
            out->hi[k] += most(most(0.0f, far), most(u[k], v[k]));
        }
        out->axis[k] = length > 0.0 ? (float)(normal[k] / length) : out->axis[k];
    }
    out->flags = 0;
    if (!(kind & LIGHT_TWO_SIDED))
        return;
    out->flags = FLAG_TWO_SIDED;
    const float *a = out->axis;
    if (a[2] < 0.0f || (a[2] == 0.0f && (a[1] < 0.0f || (a[1] == 0.0f && a[0] < 0.0f))))
        for (int k = 0; k < 3; k++)
            out->axis[k] = -out->axis[k];
}

static void set_item(struct item *out, const struct light *lights, const struct light_shape *shapes,
                     const float *power, uint32_t index)
{
    const struct light *light = &lights[index];
    const float4 org = light->org_range;
    const float4 color = light->color_kind;
    uint32_t kind;
    memcpy(&kind, &color.w, sizeof(kind));
    const uint32_t type = kind & LIGHT_TYPE_MASK;
    const struct light_shape *shape =
        type != LIGHT_POINT ? &shapes[kind >> LIGHT_SHAPE_SHIFT] : NULL;
    *out = (struct item){
        .lo = {org.x, org.y, org.z},
        .hi = {org.x, org.y, org.z},
        .axis = {0.0f, 0.0f, 1.0f},
        .power = (float)color_luminance(color.x, color.y, color.z),
        .range = org.w > LIGHT_NO_RANGE ? org.w : FLT_MAX,
        .flags = FLAG_ALL,
        .light = index,
    };
    if (type == LIGHT_SPOT) {
        // The cone ends where scale * cos + offset = 0.
        out->axis[0] = shape->edge_u.x;
        out->axis[1] = shape->edge_u.y;
        out->axis[2] = shape->edge_u.z;
        out->cos_e = least(most(-shape->edge_v.w / shape->edge_u.w, -1.0f), 1.0f);
        out->flags = 0;
    } else if (type != LIGHT_POINT) {
        set_surface(out, shape, kind);
        out->power = (float)(power[index] / (kind & LIGHT_TWO_SIDED ? 2.0 * M_PI : M_PI));
    }
}

// ---- Cost

// Cosine of a cone about the middle of the box of axes that holds them all, and that middle.
static double box_cone(double *middle, const struct gathered *set)
{
    double length2 = 0.0;
    double radius2 = 0.0;
    for (int k = 0; k < 3; k++) {
        const double half = 0.5 * ((double)set->axis_hi[k] - set->axis_lo[k]);
        middle[k] = 0.5 * ((double)set->axis_hi[k] + set->axis_lo[k]);
        length2 += middle[k] * middle[k];
        radius2 += half * half;
    }
    // A unit vector no farther than the radius from the middle: by the law of cosines.
    const double length = sqrt(length2);
    const double cosine = (1.0 + length2 - radius2) / (2.0 * length);
    return length > 1e-3 ? fmin(fmax(cosine, -1.0), 1.0) : -1.0;
}

// The solid angle measure of a cone (Conty Estevez and Kulla, equation 1), by the cosines of both
// of its angles.
static double cone_measure(double cos_o, double cos_e)
{
    const double sin_o = sqrt(fmax(1.0 - cos_o * cos_o, 0.0));
    const double sin_e = sqrt(fmax(1.0 - cos_e * cos_e, 0.0));
    const double theta_o = acosf((float)cos_o);
    double theta_w = M_PI;
    double cos_last = cos_o; // cos(theta_o - 2 theta_w)
    if (cos_o > -cos_e) {    // theta_o + theta_e < pi
        theta_w = theta_o + acosf((float)cos_e);
        cos_last = cos_o * (2.0 * cos_e * cos_e - 1.0) - sin_o * 2.0 * sin_e * cos_e;
    }
    return 2.0 * M_PI * (1.0 - cos_o) +
           0.5 * M_PI * (2.0 * theta_w * sin_o - cos_last - 2.0 * theta_o * sin_o + cos_o);
}

// Cost of drawing from a set (equation 2): power, times cone, times surface; thin nodes count more.
static double set_cost(const struct gathered *set, double regularity)
{
    if (set->count == 0)
        return 0.0;
    const double x = (double)set->hi[0] - set->lo[0];
    const double y = (double)set->hi[1] - set->lo[1];
    const double z = (double)set->hi[2] - set->lo[2];
    const double surface = x * y + y * z + z * x + LINE_PART * (x * x + y * y + z * z);
    double middle[3];
    const double cone =
        set->flags & FLAG_ALL ? 4.0 * M_PI : cone_measure(box_cone(middle, set), set->cos_e);
    return set->power * cone * regularity * surface;
}

// ---- The tree

// Where the lights of a node are binned: by their centres.
struct bins {
    float lo[3], scale[3]; // bin = (centre - lo) * scale; scale 0 where centres coincide
    int count;
};

static inline int bin_of(const struct bins *bins, const struct item *item, int axis)
{
    const int bin = (int)((center(item, axis) - bins->lo[axis]) * bins->scale[axis]);
    return bin < 0 ? 0 : bin >= bins->count ? bins->count - 1 : bin;
}

static struct bins make_bins(const struct item *items, uint32_t count)
{
    struct bins bins = {.lo = {FLT_MAX, FLT_MAX, FLT_MAX},
                        .count = count < FEW ? BIN_COUNT_FEW : BIN_COUNT};
    float hi[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            bins.lo[k] = least(bins.lo[k], center(&items[i], k));
            hi[k] = most(hi[k], center(&items[i], k));
        }
    }
    for (int k = 0; k < 3; k++) {
        const float scale = (float)bins.count / (hi[k] - bins.lo[k]);
        bins.scale[k] = hi[k] > bins.lo[k] && scale < FLT_MAX ? scale : 0.0f;
    }
    return bins;
}

// The cheapest plane over all axes; false if the centres coincide.
static bool find_plane(int *axis_out, int *plane_out, const struct bins *bins,
                       const struct item *items, uint32_t count, const struct gathered *node)
{
    struct gathered sets[3][BIN_COUNT];
    double best = DBL_MAX;
    double longest = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        longest = fmax(longest, (double)node->hi[axis] - node->lo[axis]);
        for (int i = 0; i < bins->count; i++)
            sets[axis][i] = nothing;
    }
    for (uint32_t i = 0; i < count; i++)
        for (int axis = 0; axis < 3; axis++)
            gather(&sets[axis][bin_of(bins, &items[i], axis)], &items[i]);

    for (int axis = 0; axis < 3; axis++) {
        if (!(bins->scale[axis] > 0.0f))
            continue;
        const double width = (double)node->hi[axis] - node->lo[axis];
        const double regularity = width > 0.0 ? longest / width : 1.0;
        double right_cost[BIN_COUNT];
        struct gathered right = nothing;
        for (int i = bins->count - 1; i > 0; i--) {
            const bool same = sets[axis][i].count == 0 && i + 1 < bins->count;
            unite(&right, &sets[axis][i]);
            right_cost[i] = same ? right_cost[i + 1] : set_cost(&right, regularity);
        }
        struct gathered left = nothing;
        for (int i = 1; i < bins->count; i++) {
            unite(&left, &sets[axis][i - 1]);
            if (sets[axis][i - 1].count == 0)
                continue; // as the plane before
            const double cost = set_cost(&left, regularity) + right_cost[i];
            if (left.count < count && cost < best) {
                best = cost;
                *axis_out = axis;
                *plane_out = i;
            }
        }
    }
    return best < DBL_MAX;
}

// Moves the lights of one side of the plane to the front; returns how many.
static uint32_t partition(struct item *items, uint32_t count, const struct bins *bins, int axis,
                          int plane)
{
    uint32_t split = 0;
    for (uint32_t i = 0; i < count; i++) {
        if (bin_of(bins, &items[i], axis) < plane) {
            const struct item item = items[i];
            items[i] = items[split];
            items[split++] = item;
        }
    }
    return split;
}

// Writes the bounds of a set, its cone as narrow as its axis allows.
static void set_bounds(struct light_bounds *out, const struct gathered *set,
                       const struct item *items)
{
    double middle[3];
    box_cone(middle, set);
    const double length = vec3_length(middle);
    memcpy(out->lo, set->lo, sizeof(out->lo));
    memcpy(out->hi, set->hi, sizeof(out->hi));
    for (int k = 0; k < 3; k++)
        out->axis[k] = length > 1e-3 ? (float)(middle[k] / length) : (float)(k == 2);
    out->cos_e = set->cos_e;
    out->power = (float)fmin(set->power, FLT_MAX);
    out->range = set->range;
    out->two_sided = (set->flags & FLAG_TWO_SIDED) != 0;
    out->cos_o = set->flags & FLAG_ALL ? -1.0f : 1.0f;
    for (uint32_t i = 0; i < set->count && !(set->flags & FLAG_ALL); i++) {
        const float *a = items[i].axis;
        const float cosine = a[0] * out->axis[0] + a[1] * out->axis[1] + a[2] * out->axis[2];
        const bool both = (items[i].flags & FLAG_TWO_SIDED) != 0;
        out->cos_o = least(out->cos_o, both ? fabsf(cosine) : cosine);
    }
}

// Builds the subtree of items[0 .. count) at nodes[index]; its nodes below stand from `free` on,
// 2 * count - 2 of them.
static void build_node(const struct builder *b, uint32_t index, struct item *items, uint32_t count,
                       uint32_t free, int depth)
{
    struct light_cluster *node = &b->nodes[index];
    struct gathered set = nothing;
    for (uint32_t i = 0; i < count; i++)
        gather(&set, &items[i]);
    set_bounds(&node->bounds, &set, items);
    node->count = count;
    node->left = free;
    if (count == 1) {
        node->left = items[0].light;
        return;
    }

    uint32_t left_count = 0;
    if (depth < BALANCE_DEPTH && count > 2) {
        int axis = 0;
        int plane = 0;
        const struct bins bins = make_bins(items, count);
        if (find_plane(&axis, &plane, &bins, items, count, &set))
            left_count = partition(items, count, &bins, axis, plane);
    }
    if (left_count == 0 || left_count == count)
        left_count = count / 2;
    const uint32_t left_free = free + 2;
    const uint32_t right_free = left_free + 2 * left_count - 2;
#pragma omp task if (left_count > TASK_LIGHTS)
    build_node(b, free, items, left_count, left_free, depth + 1);
    build_node(b, free + 1, items + left_count, count - left_count, right_free, depth + 1);
#pragma omp taskwait
}

enum status light_clusters_build(struct light_cluster **out, const struct light *lights,
                                 const struct light_shape *shapes, const float *power,
                                 uint32_t light_count)
{
    struct builder b = {
        .items = array_alloc(light_count, sizeof(*b.items)),
        .nodes = array_alloc(2 * (size_t)light_count, sizeof(*b.nodes)),
    };
    if (b.items == NULL || b.nodes == NULL) {
        free(b.nodes);
        free(b.items);
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH over %u lights", light_count);
    }
    for (uint32_t i = 0; i < light_count; i++)
        set_item(&b.items[i], lights, shapes, power, i);
#pragma omp parallel
#pragma omp single
    build_node(&b, 0, b.items, light_count, 1, 0);
    free(b.items);
    *out = b.nodes;
    return STATUS_OK;
}
