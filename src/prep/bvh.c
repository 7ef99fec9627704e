#include "prep/bvh.h"

#include <assert.h>
#include <float.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/box.h"
#include "shared/bvh.h"

#define PLANE_COUNT 8                    // candidates an axis (thesis section 3.1)
#define BIN_COUNT   (PLANE_COUNT + 1)    // slabs between them
#define DEPTH_LIMIT (BVH_STACK_SIZE - 4) // nodes on the longest way down

// A node with fewer references is built by the thread that met it: some 0.2 ms of work, well above
// the cost of a task.
#define TASK_REFS 1024u

// What all tasks share. The references of a node stand together in both arrays.
struct builder {
    struct box *boxes;            // [ref_count]
    uint32_t *order;              // [ref_count] index of the reference each box is of
    struct bvh_build_node *nodes; // [2 ref_count], with holes
    uint32_t leaf_size;
};

// The references of one node.
struct range {
    uint32_t first, count;
    uint32_t node;  // where the node stands
    uint32_t pair;  // first of the count - 1 places for pairs of nodes that are its own
    uint32_t depth; // 1 for the root
};

// A way to split a node: references with bin_of() < plane go left.
struct split {
    int axis;  // -1: none
    int plane; // 1 .. PLANE_COUNT
    float lo;  // of the centroids on the axis
    float scale;
};

static inline int bin_of(const struct box *box, int axis, float lo, float scale)
{
    const float place = (box_center(box, axis) - lo) * scale; // NaN if the extent overflows
    return place < PLANE_COUNT ? (int)place : PLANE_COUNT;
}

// Finds the cheapest plane of one axis from its bins. `best` is the cost to beat.
static void sweep(struct split *split, double *best, int axis, const struct box *bins,
                  const uint32_t *counts)
{
    // From the right: cost of all that lies at or beyond each plane.
    double right_cost[BIN_COUNT];
    struct box box = box_empty;
    uint32_t count = 0;
    for (int i = PLANE_COUNT; i > 0; i--) {
        box_unite(&box, &bins[i]);
        count += counts[i];
        right_cost[i] =
            count > 0 ? count * box_half_area(box.lo, box.hi) : -1.0; // -1: nothing there
    }

    // From the left: add the cost of all before it.
    box = box_empty;
    count = 0;
    for (int i = 1; i < BIN_COUNT; i++) {
        box_unite(&box, &bins[i - 1]);
        count += counts[i - 1];
        if (count == 0 || right_cost[i] < 0.0)
            continue; // the plane does not separate
        const double cost = right_cost[i] + count * box_half_area(box.lo, box.hi);
        if (cost < *best) {
            *best = cost;
            split->axis = axis;
            split->plane = i;
        }
    }
}

// Picks the cheapest of the 24 candidates by the surface area heuristic. split.axis is -1 if none
// separates the centroids.
static struct split choose_split(const struct box *boxes, uint32_t count, const struct box *centers)
{
    struct box bins[3][BIN_COUNT];
    uint32_t counts[3][BIN_COUNT] = {{0}};
    float scale[3]; // bins a metre
    for (int axis = 0; axis < 3; axis++) {
        // With an extent of nothing, or too little for its inverse, all goes into bin 0.
        const float extent = centers->hi[axis] - centers->lo[axis];
        scale[axis] = extent > FLT_MIN * 16.0f ? BIN_COUNT / extent : 0.0f;
        for (int i = 0; i < BIN_COUNT; i++)
            bins[axis][i] = box_empty;
    }

    for (uint32_t i = 0; i < count; i++) {
        for (int axis = 0; axis < 3; axis++) {
            const int bin = bin_of(&boxes[i], axis, centers->lo[axis], scale[axis]);
            box_unite(&bins[axis][bin], &boxes[i]);
            counts[axis][bin]++;
        }
    }

    struct split split = {.axis = -1};
    double best = DBL_MAX;
    for (int axis = 0; axis < 3; axis++)
        sweep(&split, &best, axis, bins[axis], counts[axis]);
    if (split.axis >= 0) {
        split.lo = centers->lo[split.axis];
        split.scale = scale[split.axis];
    }
    return split;
}

// Reorders the references of a range by a split. Returns how many went left.
static uint32_t partition(struct builder *builder, const struct range *range,
                          const struct split *split)
{
    uint32_t i = range->first;
    uint32_t end = range->first + range->count;
    while (i < end) {
        if (bin_of(&builder->boxes[i], split->axis, split->lo, split->scale) < split->plane)
            i++;
        else
            boxes_swap(builder->boxes, builder->order, i, --end);
    }
    return i - range->first;
}

// Builds the subtree of a range. Where it stands and what is in it depends on the range alone, so
// any order of tasks gives the same tree.
static void build_node(struct builder *builder, struct range range)
{
    struct bvh_build_node *node = &builder->nodes[range.node];
    const struct box *boxes = builder->boxes + range.first;
    struct box bounds, centers;
    boxes_bound(&bounds, &centers, boxes, range.count);
    memcpy(node->lo, bounds.lo, sizeof(node->lo));
    memcpy(node->hi, bounds.hi, sizeof(node->hi));
    if (range.count < builder->leaf_size) {
        node->left = range.first;
        node->count = range.count;
        return;
    }

    // Split by cost, or in half where no plane separates or the tree gets too deep.
    uint32_t left_count = 0;
    if (range.depth + boxes_levels(range.count) < DEPTH_LIMIT) {
        const struct split split = choose_split(boxes, range.count, &centers);
        if (split.axis >= 0)
            left_count = partition(builder, &range, &split);
    }
    if (left_count == 0 || left_count == range.count)
        left_count = boxes_halve(builder->boxes + range.first, builder->order + range.first,
                                 range.count, &centers);

    // One pair of places is for the children; they share out the others by their references.
    node->left = 1 + 2 * range.pair;
    node->count = 0;
    const struct range left = {range.first, left_count, node->left, range.pair + 1,
                               range.depth + 1};
    const struct range right = {range.first + left_count, range.count - left_count, node->left + 1,
                                range.pair + left_count, range.depth + 1};
    if (left.count >= TASK_REFS) {
#pragma omp task
        build_node(builder, left);
    } else {
        build_node(builder, left);
    }
    build_node(builder, right);
}

// Copies a subtree without the holes, depth first. Returns the nodes on its longest way down.
static uint32_t copy_node(struct bvh *bvh, uint32_t to, const struct bvh_build_node *from_nodes,
                          uint32_t from, const uint32_t *order)
{
    struct bvh_build_node *node = &bvh->nodes[to];
    *node = from_nodes[from];
    if (node->count > 0) {
        memcpy(bvh->order + bvh->ref_count, order + node->left, node->count * sizeof(*order));
        node->left = bvh->ref_count;
        bvh->ref_count += node->count;
        return 1;
    }
    const uint32_t from_left = node->left;
    node->left = bvh->node_count;
    bvh->node_count += 2;
    const uint32_t left_depth = copy_node(bvh, node->left, from_nodes, from_left, order);
    const uint32_t right_depth = copy_node(bvh, node->left + 1, from_nodes, from_left + 1, order);
    return 1 + (left_depth > right_depth ? left_depth : right_depth);
}

// Counts what is in a subtree.
static void count_below(uint32_t *node_count, uint32_t *ref_count,
                        const struct bvh_build_node *nodes, uint32_t node)
{
    ++*node_count;
    *ref_count += nodes[node].count;
    if (nodes[node].count > 0)
        return;
    count_below(node_count, ref_count, nodes, nodes[node].left);
    count_below(node_count, ref_count, nodes, nodes[node].left + 1);
}

enum status bvh_take(struct bvh *out, const struct bvh_build_node *nodes, const uint32_t *order)
{
    struct bvh bvh = {0};
    uint32_t node_count = 0;
    uint32_t ref_count = 0;
    count_below(&node_count, &ref_count, nodes, 0);
    bvh.nodes = array_alloc(node_count, sizeof(*bvh.nodes));
    bvh.order = array_alloc(ref_count, sizeof(*bvh.order));
    if (bvh.nodes == NULL || bvh.order == NULL) {
        bvh_free(&bvh);
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u references", ref_count);
    }
    bvh.node_count = 1;
    bvh.depth = copy_node(&bvh, 0, nodes, 0, order);
    *out = bvh;
    return STATUS_OK;
}

static void load_refs(struct builder *builder, const struct tri_ref *refs, uint32_t ref_count)
{
#pragma omp parallel for schedule(static)
    for (uint32_t i = 0; i < ref_count; i++) {
        struct box *box = &builder->boxes[i];
        *box = (struct box){{0.0f}, {0.0f}};
        memcpy(box->lo, refs[i].lo, sizeof(refs[i].lo));
        memcpy(box->hi, refs[i].hi, sizeof(refs[i].hi));
        builder->order[i] = i;
    }
}

enum status bvh_build(struct bvh *out, const struct tri_ref *refs, uint32_t ref_count,
                      uint32_t leaf_size)
{
    enum status status = STATUS_OK;
    assert(leaf_size >= 2 && leaf_size <= BVH_LEAF_MAX + 1);
    if (ref_count == 0) {
        *out = (struct bvh){0};
        return STATUS_OK;
    }
    struct builder builder = {
        .boxes = array_alloc(ref_count, sizeof(*builder.boxes)),
        .order = array_alloc(ref_count, sizeof(*builder.order)),
        .nodes = array_alloc(2 * (size_t)ref_count, sizeof(*builder.nodes)),
        .leaf_size = leaf_size,
    };
    if (builder.order == NULL || builder.boxes == NULL || builder.nodes == NULL) {
        status =
            status_fail(STATUS_NO_MEMORY, "no memory to build a BVH of %u references", ref_count);
        goto cleanup;
    }

    load_refs(&builder, refs, ref_count);
#pragma omp parallel
#pragma omp single
    build_node(&builder, (struct range){0, ref_count, 0, 0, 1});
    status = bvh_take(out, builder.nodes, builder.order);

cleanup:
    free(builder.nodes);
    free(builder.order);
    free(builder.boxes);
    return status;
}

double bvh_sah_cost(const struct bvh *bvh)
{
    double cost = 0.0;
    if (bvh->node_count == 0)
        return cost;
    const double root_area = box_half_area(bvh->nodes[0].lo, bvh->nodes[0].hi);
    for (uint32_t i = 0; i < bvh->node_count; i++) {
        const struct bvh_build_node *node = &bvh->nodes[i];
        const double area = box_half_area(node->lo, node->hi);
        const double probability = root_area > 0.0 ? area / root_area : 1.0;
        cost += probability * (node->count > 0 ? node->count : 1);
    }
    return cost;
}

void bvh_free(struct bvh *bvh)
{
    free(bvh->order);
    free(bvh->nodes);
    *bvh = (struct bvh){0};
}
