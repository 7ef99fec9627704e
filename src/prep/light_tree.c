#include "prep/light_tree.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/vec3.h"

// Levels at which every split is a candidate. Measured on 1000 lights with ranges of 5 to 10 m in a
// hall of 50 x 5 x 50 m: without bound a light is 456 steps from the root, with 64 levels 72, with
// 16 levels 27, with none 11; the variance of drawing falls in the same order.
#define GREEDY_DEPTH 16

// Least probability of a child: random numbers of 24 bits still find it, and no light is lost.
#define SHARE_MIN 0x1p-20

// An axis-aligned box, m.
struct box {
    float lo[3], hi[3];
};

// A light's place on an axis, to sort by.
struct key {
    float center;
    uint32_t light;
};

// What building needs. Each axis keeps the lights in the order of their centres, those of one node
// side by side in the same range of all three.
struct builder {
    struct light_tree *tree;
    const struct light *lights;
    const struct light_shape *shapes;
    const float *power;
    struct box *reach;  // [light_count] the box of what each light reaches
    uint32_t *order[3]; // [light_count] lights by centre
    uint32_t *kept;     // [light_count] scratch: right side of a partition
    double *right_cost; // [light_count] scratch: volume of the lights from i on
    bool *goes_left;    // [light_count] by light
};

// A way to split a node: the first `count` lights along the axis go left.
struct split {
    int axis;
    uint32_t count;
};

static const struct box empty_box = {{FLT_MAX, FLT_MAX, FLT_MAX}, {-FLT_MAX, -FLT_MAX, -FLT_MAX}};
static const struct box boundless_box = {{-FLT_MAX, -FLT_MAX, -FLT_MAX},
                                         {FLT_MAX, FLT_MAX, FLT_MAX}};

static void box_unite(struct box *box, const struct box *other)
{
    for (int k = 0; k < 3; k++) {
        box->lo[k] = other->lo[k] < box->lo[k] ? other->lo[k] : box->lo[k];
        box->hi[k] = other->hi[k] > box->hi[k] ? other->hi[k] : box->hi[k];
    }
}

static double volume(const struct box *box)
{
    return ((double)box->hi[0] - box->lo[0]) * ((double)box->hi[1] - box->lo[1]) *
           ((double)box->hi[2] - box->lo[2]);
}

static bool is_ranged(const struct light *light)
{
    return light->org_range.w > LIGHT_NO_RANGE;
}

// The box of what a light reaches.
static struct box find_reach(const struct light *light)
{
    if (!is_ranged(light))
        return boundless_box;
    const double org[3] = {light->org_range.x, light->org_range.y, light->org_range.z};
    struct box box;
    for (int k = 0; k < 3; k++) {
        box.lo[k] = float_below(org[k] - light->org_range.w);
        box.hi[k] = float_above(org[k] + light->org_range.w);
    }
    return box;
}

// The middle of a light.
static void find_center(float *out, const struct builder *builder, uint32_t index)
{
    const struct light *light = &builder->lights[index];
    uint kind;
    memcpy(&kind, &light->color_kind.w, sizeof(kind));
    const uint type = kind & LIGHT_TYPE_MASK;
    out[0] = light->org_range.x;
    out[1] = light->org_range.y;
    out[2] = light->org_range.z;
    if (type != LIGHT_TRIANGLE && type != LIGHT_RECTANGLE)
        return;
    const struct light_shape *shape = &builder->shapes[kind >> LIGHT_SHAPE_SHIFT];
    const float part = type == LIGHT_RECTANGLE ? 0.5f : 1.0f / 3.0f;
    out[0] += part * (shape->edge_u.x + shape->edge_v.x);
    out[1] += part * (shape->edge_u.y + shape->edge_v.y);
    out[2] += part * (shape->edge_u.z + shape->edge_v.z);
}

static int compare_keys(const void *left, const void *right)
{
    const struct key *a = left;
    const struct key *b = right;
    if (a->center != b->center)
        return a->center < b->center ? -1 : 1;
    return a->light < b->light ? -1 : a->light > b->light;
}

// Sorts the lights along each axis, those with a range before those without. Returns the number of
// the former; false in *ok if there is no memory.
static uint32_t sort_lights(struct builder *builder, uint32_t count, bool *ok)
{
    uint32_t ranged_count = 0;
    for (uint32_t i = 0; i < count; i++)
        ranged_count += is_ranged(&builder->lights[i]);
    struct key *keys = array_alloc(count, sizeof(*keys));
    *ok = keys != NULL;
    if (keys == NULL)
        return 0;

    for (int axis = 0; axis < 3; axis++) {
        uint32_t ranged = 0;
        uint32_t other = ranged_count;
        for (uint32_t i = 0; i < count; i++) {
            float center[3];
            find_center(center, builder, i);
            keys[is_ranged(&builder->lights[i]) ? ranged++ : other++] =
                (struct key){center[axis], i};
        }
        qsort(keys, ranged_count, sizeof(*keys), compare_keys);
        qsort(keys + ranged_count, count - ranged_count, sizeof(*keys), compare_keys);
        for (uint32_t i = 0; i < count; i++)
            builder->order[axis][i] = keys[i].light;
    }
    free(keys);
    return ranged_count;
}

// Finds the split of the least summed volume of children, of all that leave `least` lights on each
// side; of equals the most even one, so that heaps of equal lights do not make a list.
static struct split find_least_volume(struct builder *builder, uint32_t first, uint32_t count,
                                      uint32_t least)
{
    struct split best = {0, count / 2};
    double best_cost = INFINITY;
    uint32_t best_uneven = UINT32_MAX;
    for (int axis = 0; axis < 3; axis++) {
        const uint32_t *order = builder->order[axis] + first;
        struct box box = empty_box;
        for (uint32_t i = count - 1; i > 0; i--) {
            box_unite(&box, &builder->reach[order[i]]);
            builder->right_cost[i] = volume(&box);
        }

        box = empty_box;
        for (uint32_t i = 1; i < count; i++) {
            box_unite(&box, &builder->reach[order[i - 1]]);
            if (i < least || count - i < least)
                continue;
            const double cost = volume(&box) + builder->right_cost[i];
            const uint32_t uneven = 2 * i > count ? 2 * i - count : count - 2 * i;
            if (cost < best_cost || (cost == best_cost && uneven < best_uneven)) {
                best = (struct split){axis, i};
                best_cost = cost;
                best_uneven = uneven;
            }
        }
    }
    return best;
}

// Halves lights across the axis on which their centres reach farthest.
static struct split find_half(const struct builder *builder, uint32_t first, uint32_t count)
{
    int longest = 0;
    double extents[3];
    for (int axis = 0; axis < 3; axis++) {
        float lo[3], hi[3];
        find_center(lo, builder, builder->order[axis][first]);
        find_center(hi, builder, builder->order[axis][first + count - 1]);
        extents[axis] = (double)hi[axis] - lo[axis];
        if (extents[axis] > extents[longest])
            longest = axis;
    }
    return (struct split){longest, count / 2};
}

// Divides the lights of a range on all axes by a split; each keeps its order.
static void partition(struct builder *builder, uint32_t first, uint32_t count, struct split split)
{
    const uint32_t *by = builder->order[split.axis] + first;
    for (uint32_t i = 0; i < count; i++)
        builder->goes_left[by[i]] = i < split.count;

    for (int axis = 0; axis < 3; axis++) {
        uint32_t *order = builder->order[axis] + first;
        uint32_t left = 0;
        uint32_t right = 0;
        for (uint32_t i = 0; i < count; i++) {
            if (builder->goes_left[order[i]])
                order[left++] = order[i];
            else
                builder->kept[right++] = order[i];
        }
        memcpy(order + left, builder->kept, right * sizeof(*order));
    }
}

static void set_node(struct light_tree *tree, uint32_t node, uint32_t parent, const struct box *box,
                     float left_probability, uint child)
{
    tree->parents[node] = parent;
    tree->nodes[node].lo_left = (float4){box->lo[0], box->lo[1], box->lo[2], left_probability};
    tree->nodes[node].hi_child = (float4){box->hi[0], box->hi[1], box->hi[2], 0.0f};
    memcpy(&tree->nodes[node].hi_child.w, &child, sizeof(child));
}

// The share of the left lights in the power of a range, neither 0 nor 1 in float.
static float left_share(const struct builder *builder, uint32_t first, uint32_t count,
                        uint32_t left_count)
{
    double left = 0.0;
    double right = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const double power = builder->power[builder->order[0][first + i]];
        *(i < left_count ? &left : &right) += power;
    }
    return (float)fmin(fmax(left / (left + right), SHARE_MIN), 1.0 - SHARE_MIN);
}

// Builds the subtree of a range at a node, depth first: n lights take the next 2 n - 1 nodes. Calls
// itself no deeper than the tree, whose depth the header bounds.
static void build_node(struct builder *builder, uint32_t first, uint32_t count, uint32_t node,
                       uint32_t parent, uint32_t depth)
{
    struct light_tree *tree = builder->tree;
    struct box box = empty_box;
    for (uint32_t i = 0; i < count; i++)
        box_unite(&box, &builder->reach[builder->order[0][first + i]]);
    if (count == 1) {
        const uint32_t light = builder->order[0][first];
        set_node(tree, node, parent, &box, 0.0f, LIGHT_NODE_LEAF | light);
        tree->leaves[light] = node;
        return;
    }

    // All lights of a range are of one kind.
    const bool ranged = is_ranged(&builder->lights[builder->order[0][first]]);
    const uint32_t least = depth < GREEDY_DEPTH ? 1 : (count + 3) / 4;
    const struct split split =
        ranged ? find_least_volume(builder, first, count, least) : find_half(builder, first, count);
    partition(builder, first, count, split);

    const float share = ranged ? 0.5f : left_share(builder, first, count, split.count);
    const uint32_t right = node + 2 * split.count;
    set_node(tree, node, parent, &box, share, right);
    build_node(builder, first, split.count, node + 1, node, depth + 1);
    build_node(builder, first + split.count, count - split.count, right, node, depth + 1);
}

// Builds the trees of both kinds and joins them where there are both.
static void build_root(struct builder *builder, uint32_t ranged_count, uint32_t count)
{
    for (uint32_t i = 0; i < count; i++)
        builder->reach[i] = find_reach(&builder->lights[i]);
    if (ranged_count == 0 || ranged_count == count) {
        build_node(builder, 0, count, 0, 0, 0);
        return;
    }
    const uint32_t right = 2 * ranged_count;
    set_node(builder->tree, 0, 0, &boundless_box, 0.5f, right);
    build_node(builder, 0, ranged_count, 1, 0, 1);
    build_node(builder, ranged_count, count - ranged_count, right, 0, 1);
}

enum status light_tree_build(struct light_tree *out, const struct light *lights,
                             const struct light_shape *shapes, const float *power,
                             uint32_t light_count)
{
    enum status status = STATUS_OK;
    struct light_tree tree = {0};
    struct builder builder = {.tree = &tree, .lights = lights, .shapes = shapes, .power = power};
    bool ok = true;
    if (light_count == 0) {
        *out = tree;
        return STATUS_OK;
    }

    tree.light_count = light_count;
    tree.node_count = 2 * light_count - 1;
    tree.nodes = array_alloc(tree.node_count, sizeof(*tree.nodes));
    tree.parents = array_alloc(tree.node_count, sizeof(*tree.parents));
    tree.leaves = array_alloc(light_count, sizeof(*tree.leaves));
    builder.reach = array_alloc(light_count, sizeof(*builder.reach));
    builder.kept = array_alloc(light_count, sizeof(*builder.kept));
    builder.right_cost = array_alloc(light_count, sizeof(*builder.right_cost));
    builder.goes_left = array_alloc(light_count, sizeof(*builder.goes_left));
    for (int axis = 0; axis < 3; axis++) {
        builder.order[axis] = array_alloc(light_count, sizeof(uint32_t));
        ok = ok && builder.order[axis] != NULL;
    }
    ok = ok && tree.nodes != NULL && tree.parents != NULL && tree.leaves != NULL &&
         builder.reach != NULL && builder.kept != NULL && builder.right_cost != NULL &&
         builder.goes_left != NULL;

    const uint32_t ranged_count = ok ? sort_lights(&builder, light_count, &ok) : 0;
    if (!ok) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for a tree of %u lights", light_count);
        goto cleanup;
    }
    build_root(&builder, ranged_count, light_count);
    *out = tree;
    tree = (struct light_tree){0}; // the caller owns it now

cleanup:
    for (int axis = 0; axis < 3; axis++)
        free(builder.order[axis]);
    free(builder.goes_left);
    free(builder.right_cost);
    free(builder.kept);
    free(builder.reach);
    light_tree_free(&tree);
    return status;
}

static bool holds(const struct light_node *node, const float *point)
{
    const float4 lo = node->lo_left;
    const float4 hi = node->hi_child;
    return lo.x <= point[0] && point[0] <= hi.x && lo.y <= point[1] && point[1] <= hi.y &&
           lo.z <= point[2] && point[2] <= hi.z;
}

double light_tree_pmf(const struct light_tree *tree, const float *point, uint32_t light)
{
    double pmf = 1.0;
    for (uint32_t node = tree->leaves[light]; node != 0; node = tree->parents[node]) {
        const uint32_t parent = tree->parents[node];
        uint right;
        memcpy(&right, &tree->nodes[parent].hi_child.w, sizeof(right));
        const uint32_t sibling = node == right ? parent + 1 : right;
        if (!holds(&tree->nodes[node], point))
            return 0.0;
        if (holds(&tree->nodes[sibling], point)) {
            const double left = tree->nodes[parent].lo_left.w;
            pmf *= node == right ? 1.0 - left : left;
        }
    }
    return holds(&tree->nodes[0], point) ? pmf : 0.0;
}

void light_tree_free(struct light_tree *tree)
{
    free(tree->leaves);
    free(tree->parents);
    free(tree->nodes);
    *tree = (struct light_tree){0};
}
