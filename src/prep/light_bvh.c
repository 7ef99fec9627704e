#include "prep/light_bvh.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/vec3.h"

#define BIN_COUNT     12 // candidate planes of an axis, less one (pbrt 4ed section 12.6.3)
#define BALANCE_DEPTH 40 // binary levels after which nodes are halved, so that depth stays bounded
#define TASK_LIGHTS   4096 // smaller subtrees are not worth a task
#define WIDTH         ((int)LIGHT_BVH_WIDTH)

// What is known of a set of lights.
struct bounds {
    float lo[3], hi[3]; // of positions
    double axis[3];     // unit
    double theta_o;     // widest angle between the axis and a light's own, radians
    double theta_e;     // widest angle of emission off a light's own axis, radians
    double power;
    float range;
    bool two_sided; // some light is
    bool is_empty;
};

// A node of the binary tree that is collapsed afterwards.
struct binary {
    struct bounds bounds;
    uint32_t left;  // inner: left child, right is left + 1; leaf: LIGHT_BVH_LEAF | light
    uint32_t count; // lights below
};

struct builder {
    const struct light *lights;
    const float *power;
    uint32_t *order;      // [light_count] lights, those of a node side by side
    struct binary *nodes; // [2 * light_count - 1]
};

static const struct bounds empty_bounds = {.is_empty = true};

// The unit vector at `angle` from a towards b, both unit.
static void rotate_towards(double *out, const double *a, const double *b, double angle)
{
    double side[3], axis[3], length;
    vec3_cross(axis, a, b);
    length = vec3_length(axis);
    if (length < 1e-9) { // parallel or opposite: any side will do
        const double other[3] = {fabs(a[0]) < 0.5, fabs(a[0]) >= 0.5, 0.0};
        vec3_cross(axis, a, other);
        length = vec3_length(axis);
    }
    for (int k = 0; k < 3; k++)
        axis[k] /= length;
    vec3_cross(side, axis, a);
    for (int k = 0; k < 3; k++)
        out[k] = cos(angle) * a[k] + sin(angle) * side[k];
}

// Widens the cone of `a` to hold the cone of `b` (Conty Estevez and Kulla, algorithm 1).
static void unite_cones(struct bounds *a, const struct bounds *b)
{
    const double theta_e = fmax(a->theta_e, b->theta_e);
    if (a->theta_o >= M_PI || b->theta_o >= M_PI) { // a light in all directions settles it
        a->theta_o = M_PI;
        a->theta_e = theta_e;
        return;
    }
    const double cosine = fmin(fmax(vec3_dot(a->axis, b->axis), -1.0), 1.0);
    const double between = acos(cosine);
    const bool a_wider = a->theta_o >= b->theta_o;
    const struct bounds *wide = a_wider ? a : b;
    const struct bounds *slim = a_wider ? b : a;
    double axis[3] = {wide->axis[0], wide->axis[1], wide->axis[2]};
    double theta_o = wide->theta_o;
    if (fmin(between + slim->theta_o, M_PI) > wide->theta_o) {
        theta_o = 0.5 * (wide->theta_o + between + slim->theta_o);
        if (theta_o >= M_PI)
            theta_o = M_PI;
        else
            rotate_towards(axis, wide->axis, slim->axis, theta_o - wide->theta_o);
    }
    memcpy(a->axis, axis, sizeof(axis));
    a->theta_o = theta_o;
    a->theta_e = theta_e;
}

static void unite(struct bounds *a, const struct bounds *b)
{
    if (b->is_empty)
        return;
    if (a->is_empty) {
        *a = *b;
        return;
    }
    for (int k = 0; k < 3; k++) {
        a->lo[k] = fminf(a->lo[k], b->lo[k]);
        a->hi[k] = fmaxf(a->hi[k], b->hi[k]);
    }
    unite_cones(a, b);
    a->power += b->power;
    a->range = fmaxf(a->range, b->range);
    a->two_sided |= b->two_sided;
}

// Intensity along the axis, cd; of a surface, radiance times area, its texture's mean in it.
static double luminous_intensity(const struct light *light, double power, uint32_t kind)
{
    const uint32_t type = kind & LIGHT_TYPE_MASK;
    if (type == LIGHT_POINT || type == LIGHT_SPOT)
        return 0.2126 * light->color_kind.x + 0.7152 * light->color_kind.y +
               0.0722 * light->color_kind.z;
    return power / (kind & LIGHT_TWO_SIDED ? 2.0 * M_PI : M_PI);
}

// What is known of one light.
static struct bounds light_bounds(const struct builder *b, uint32_t index)
{
    const struct light *light = &b->lights[index];
    uint32_t kind;
    memcpy(&kind, &light->color_kind.w, sizeof(kind));
    const float org[3] = {light->org_range.x, light->org_range.y, light->org_range.z};
    const float u[3] = {light->edge_u.x, light->edge_u.y, light->edge_u.z};
    const float v[3] = {light->edge_v.x, light->edge_v.y, light->edge_v.z};
    struct bounds out = {
        .axis = {0.0, 0.0, 1.0},
        .theta_o = M_PI, // all directions
        .theta_e = 0.5 * M_PI,
        .power = luminous_intensity(light, b->power[index], kind),
        .range = light->org_range.w > LIGHT_NO_RANGE ? light->org_range.w : FLT_MAX,
    };
    memcpy(out.lo, org, sizeof(org));
    memcpy(out.hi, org, sizeof(org));

    const uint32_t type = kind & LIGHT_TYPE_MASK;
    if (type == LIGHT_SPOT) {
        // The cone ends where scale * cos + offset = 0.
        vec3_load(out.axis, u);
        out.theta_o = 0.0;
        out.theta_e = acos(fmin(fmax(-(double)light->edge_v.w / light->edge_u.w, -1.0), 1.0));
    } else if (type != LIGHT_POINT) {
        double du[3], dv[3], normal[3];
        vec3_load(du, u);
        vec3_load(dv, v);
        vec3_cross(normal, du, dv);
        const double length = vec3_length(normal);
        for (int k = 0; k < 3; k++) {
            const float far = type == LIGHT_RECTANGLE ? u[k] + v[k] : u[k];
            out.lo[k] += fminf(fminf(0.0f, far), fminf(u[k], v[k]));
            out.hi[k] += fmaxf(fmaxf(0.0f, far), fmaxf(u[k], v[k]));
            out.axis[k] = length > 0.0 ? normal[k] / length : out.axis[k];
        }
        out.theta_o = 0.0;
        out.two_sided = (kind & LIGHT_TWO_SIDED) != 0;
        out.range = FLT_MAX;
    }
    return out;
}

// The solid angle measure of a cone (Conty Estevez and Kulla, equation 1).
static double cone_measure(const struct bounds *b)
{
    const double theta_w = fmin(b->theta_o + b->theta_e, M_PI);
    const double sin_o = sin(b->theta_o);
    const double cos_o = cos(b->theta_o);
    return 2.0 * M_PI * (1.0 - cos_o) +
           0.5 * M_PI *
               (2.0 * theta_w * sin_o - cos(b->theta_o - 2.0 * theta_w) - 2.0 * b->theta_o * sin_o +
                cos_o);
}

// Cost of drawing from a set (equation 2): power, times cone, times surface; thin nodes count more.
static double set_cost(const struct bounds *b, double regularity)
{
    if (b->is_empty)
        return 0.0;
    const double x = (double)b->hi[0] - b->lo[0];
    const double y = (double)b->hi[1] - b->lo[1];
    const double z = (double)b->hi[2] - b->lo[2];
    return b->power * cone_measure(b) * regularity * (x * y + y * z + z * x);
}

static float center(const struct builder *b, uint32_t light, int axis)
{
    const struct bounds bounds = light_bounds(b, light);
    return 0.5f * bounds.lo[axis] + 0.5f * bounds.hi[axis];
}

static int bin_of(float center, float lo, float hi)
{
    const int bin = (int)(BIN_COUNT * ((center - lo) / (hi - lo)));
    return bin < 0 ? 0 : bin >= BIN_COUNT ? BIN_COUNT - 1 : bin;
}

// The cheapest plane over all axes; false if the centres coincide.
static bool find_plane(int *axis_out, int *plane_out, const struct builder *b, uint32_t first,
                       uint32_t count, const struct bounds *node, const float *lo, const float *hi)
{
    double best = DBL_MAX;
    double longest = 0.0;
    for (int k = 0; k < 3; k++)
        longest = fmax(longest, (double)node->hi[k] - node->lo[k]);
    for (int axis = 0; axis < 3; axis++) {
        if (!(hi[axis] > lo[axis]))
            continue;
        struct bounds bins[BIN_COUNT];
        for (int i = 0; i < BIN_COUNT; i++)
            bins[i] = empty_bounds;
        for (uint32_t i = first; i < first + count; i++) {
            const struct bounds light = light_bounds(b, b->order[i]);
            const float c = 0.5f * light.lo[axis] + 0.5f * light.hi[axis];
            unite(&bins[bin_of(c, lo[axis], hi[axis])], &light);
        }
        const double width = (double)node->hi[axis] - node->lo[axis];
        const double regularity = width > 0.0 ? longest / width : 1.0;
        double right_cost[BIN_COUNT];
        struct bounds right = empty_bounds;
        for (int i = BIN_COUNT - 1; i > 0; i--) {
            unite(&right, &bins[i]);
            right_cost[i] = set_cost(&right, regularity);
        }
        struct bounds left = empty_bounds;
        for (int i = 1; i < BIN_COUNT; i++) {
            unite(&left, &bins[i - 1]);
            const double cost = set_cost(&left, regularity) + right_cost[i];
            if (!left.is_empty && cost < best) {
                best = cost;
                *axis_out = axis;
                *plane_out = i;
            }
        }
    }
    return best < DBL_MAX;
}

// Moves the lights of one side of the plane to the front; returns how many.
static uint32_t partition(const struct builder *b, uint32_t first, uint32_t count, int axis,
                          int plane, const float *lo, const float *hi)
{
    uint32_t split = first;
    for (uint32_t i = first; i < first + count; i++) {
        const uint32_t light = b->order[i];
        if (bin_of(center(b, light, axis), lo[axis], hi[axis]) < plane) {
            b->order[i] = b->order[split];
            b->order[split++] = light;
        }
    }
    return split - first;
}

// Builds the subtree of order[first .. first + count) at nodes[index]; its nodes below stand from
// `free` on, 2 * count - 2 of them.
static void build_binary(struct builder *b, uint32_t index, uint32_t first, uint32_t count,
                         uint32_t free, int depth)
{
    struct binary *node = &b->nodes[index];
    node->bounds = empty_bounds;
    node->count = count;
    float lo[3] = {FLT_MAX, FLT_MAX, FLT_MAX};
    float hi[3] = {-FLT_MAX, -FLT_MAX, -FLT_MAX};
    for (uint32_t i = first; i < first + count; i++) {
        const struct bounds light = light_bounds(b, b->order[i]);
        unite(&node->bounds, &light);
        for (int k = 0; k < 3; k++) {
            const float c = 0.5f * light.lo[k] + 0.5f * light.hi[k];
            lo[k] = fminf(lo[k], c);
            hi[k] = fmaxf(hi[k], c);
        }
    }
    if (count == 1) {
        node->left = LIGHT_BVH_LEAF | b->order[first];
        return;
    }

    int axis = 0;
    int plane = 0;
    uint32_t left_count = 0;
    if (depth < BALANCE_DEPTH && find_plane(&axis, &plane, b, first, count, &node->bounds, lo, hi))
        left_count = partition(b, first, count, axis, plane, lo, hi);
    if (left_count == 0 || left_count == count)
        left_count = count / 2;
    node->left = free;
    const uint32_t left_free = free + 2;
    const uint32_t right_free = left_free + 2 * left_count - 2;
    const uint32_t right_count = count - left_count;
#pragma omp task if (left_count > TASK_LIGHTS)
    build_binary(b, free, first, left_count, left_free, depth + 1);
    build_binary(b, free + 1, first + left_count, right_count, right_free, depth + 1);
#pragma omp taskwait
}

static void set_row(struct light_bvh_node *node, int row, int child, float value)
{
    memcpy((char *)node + (row * WIDTH + child) * (int)sizeof(float), &value, sizeof(value));
}

// Writes one child's column.
static void write_child(struct light_bvh_node *node, int child, const struct bounds *bounds,
                        uint32_t word)
{
    double radius2 = 0.0;
    for (int k = 0; k < 3; k++) {
        const float c = 0.5f * bounds->lo[k] + 0.5f * bounds->hi[k];
        const double half = fmax((double)bounds->hi[k] - c, (double)c - bounds->lo[k]);
        radius2 += half * half;
        set_row(node, k, child, c);
        set_row(node, 6 + k, child, (float)bounds->axis[k]);
    }
    // Angles are widened a little: a light at the very edge of a cone must not be lost to rounding.
    const double slack = 1e-3;
    float bits;
    memcpy(&bits, &word, sizeof(bits));
    set_row(node, 3, child, float_above(sqrt(radius2) * 1.000001));
    set_row(node, 4, child, (float)(bounds->two_sided ? -bounds->power : bounds->power));
    set_row(node, 5, child, bounds->range);
    set_row(node, 9, child, (float)cos(fmin(bounds->theta_o + slack, M_PI)));
    set_row(node, 10, child, (float)cos(fmin(bounds->theta_e + slack, M_PI)));
    set_row(node, 11, child, bits);
}

// The children of a wide node: the binary node's, the one of most lights opened until there are 8.
static int open_children(uint32_t *children, const struct binary *nodes, uint32_t index)
{
    int count = 0;
    if (nodes[index].count == 1) {
        children[count++] = index;
        return count;
    }
    children[count++] = nodes[index].left;
    children[count++] = nodes[index].left + 1;
    while (count < WIDTH) {
        int widest = -1;
        for (int i = 0; i < count; i++)
            if (nodes[children[i]].count > 1 &&
                (widest < 0 || nodes[children[i]].count > nodes[children[widest]].count))
                widest = i;
        if (widest < 0)
            break;
        const uint32_t left = nodes[children[widest]].left;
        children[widest] = left;
        children[count++] = left + 1;
    }
    return count;
}

// Collapses the binary tree, breadth first. source[n] is the binary node of wide node n.
static void collapse(struct light_bvh *out, const struct binary *nodes, uint32_t *source)
{
    static const struct bounds none = {.axis = {0.0, 0.0, 1.0}};
    source[0] = 0;
    out->parents[0] = LIGHT_BVH_ROOT;
    out->node_count = 1;
    for (uint32_t n = 0; n < out->node_count; n++) {
        uint32_t children[LIGHT_BVH_WIDTH];
        const int count = open_children(children, nodes, source[n]);
        for (int i = 0; i < WIDTH; i++) {
            if (i >= count) {
                write_child(&out->nodes[n], i, &none, LIGHT_BVH_EMPTY);
                continue;
            }
            const struct binary *child = &nodes[children[i]];
            uint32_t word = child->left;
            if (child->count == 1) {
                out->leaves[word & ~LIGHT_BVH_LEAF] = n << 3 | (uint32_t)i;
            } else {
                word = out->node_count++;
                source[word] = children[i];
                out->parents[word] = n << 3 | (uint32_t)i;
            }
            write_child(&out->nodes[n], i, &child->bounds, word);
        }
    }
}

enum status light_bvh_build(struct light_bvh *out, const struct light *lights, const float *power,
                            uint32_t light_count)
{
    if (light_count == 0) {
        *out = (struct light_bvh){0};
        return STATUS_OK;
    }
    enum status status = STATUS_OK;
    struct light_bvh bvh = {.light_count = light_count};
    struct builder b = {.lights = lights, .power = power};
    uint32_t *source = NULL;

    // Every wide node but the root has two lights or more of its own or a wide node below, so there
    // are fewer wide nodes than lights; shrunk to what is used at the end.
    b.order = array_alloc(light_count, sizeof(*b.order));
    b.nodes = array_alloc(2 * (size_t)light_count, sizeof(*b.nodes));
    source = array_alloc(light_count, sizeof(*source));
    bvh.nodes = array_alloc(light_count, sizeof(*bvh.nodes));
    bvh.parents = array_alloc(light_count, sizeof(*bvh.parents));
    bvh.leaves = array_alloc(light_count, sizeof(*bvh.leaves));
    if (b.order == NULL || b.nodes == NULL || source == NULL || bvh.nodes == NULL ||
        bvh.parents == NULL || bvh.leaves == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for a BVH over %u lights", light_count);
        goto cleanup;
    }
    for (uint32_t i = 0; i < light_count; i++)
        b.order[i] = i;
#pragma omp parallel
#pragma omp single
    build_binary(&b, 0, 0, light_count, 1, 0);
    collapse(&bvh, b.nodes, source);
    struct light_bvh_node *shrunk = realloc(bvh.nodes, bvh.node_count * sizeof(*bvh.nodes));
    bvh.nodes = shrunk != NULL ? shrunk : bvh.nodes;
    *out = bvh;
    bvh = (struct light_bvh){0}; // the caller owns it now

cleanup:
    light_bvh_free(&bvh);
    free(source);
    free(b.nodes);
    free(b.order);
    return status;
}

void light_bvh_free(struct light_bvh *bvh)
{
    free(bvh->nodes);
    free(bvh->parents);
    free(bvh->leaves);
    *bvh = (struct light_bvh){0};
}
