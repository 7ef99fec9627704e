#include "prep/sbvh.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/box.h"
#include "prep/object_split.h"
#include "prep/spatial_split.h"
#include "shared/bvh.h"

#define DEPTH_LIMIT (BVH_STACK_SIZE - 4) // nodes on the longest way down

// Cost of a visit of a node, in tests of a triangle. Small leaves are left to the layouts that join
// nodes, which judge for themselves what should be one. With 1, an H100 traces bounces in Sponza
// over the 4-wide BVH at 2 to 4 % fewer rays/s, and over the binary one camera rays at up to 2 %
// more; with 0.5 it does the same as with 0.7.
#define NODE_COST 0.7

// Overlap of an object split's children, part of the root's surface, from which on splits in space
// are tried (Stich et al., section 4.5). With 1e-5 as there, a build of Sponza takes 1.6 times as
// long, and no ray is faster.
#define SPLIT_ALPHA 1e-4

// References that splits may add, part of those given.
#define ALLOWANCE 0.5

// A node with fewer references is built by the thread that met it.
#define TASK_REFS 1024u

// What all tasks share. The references of a node stand together in both arrays.
struct builder {
    struct part_set parts;
    struct bvh_build_node *nodes; // [2 room], with holes
    uint32_t leaf_size;
    double overlap; // of an object split's children, half surface in m2, above which to try others
};

// The references of one node.
struct range {
    uint32_t first, count;
    uint32_t room;  // places from `first` on that are the node's own, >= count
    uint32_t node;  // where the node stands
    uint32_t pair;  // first of the room - 1 places for pairs of nodes that are its own
    uint32_t depth; // 1 for the root
};

// Splits a range's references by what is cheapest. Returns how many are left, 0 for a leaf; the
// right ones follow them, and range->count becomes the number of both.
static uint32_t split_range(struct builder *builder, struct range *range, const struct box *bounds,
                            const struct box *centers)
{
    const bool may_leaf = range->count < builder->leaf_size;
    struct part_set *parts = &builder->parts;
    if (range->depth + boxes_levels(range->count) >= DEPTH_LIMIT) // too deep for anything uneven
        return may_leaf ? 0
                        : boxes_halve(parts->boxes + range->first, parts->order + range->first,
                                      range->count, centers);

    struct object_split object;
    struct spatial_split spatial = {.cost = DBL_MAX};
    object_split_find(&object, parts, range->first, range->count, centers);
    if (range->room > range->count && object.overlap > builder->overlap)
        spatial_split_find(&spatial, parts, range->first, range->count, bounds);

    const double area = box_half_area(bounds->lo, bounds->hi);
    const double cost = object.cost < spatial.cost ? object.cost : spatial.cost;
    if (may_leaf && range->count * area <= NODE_COST * area + cost)
        return 0;
    if (spatial.cost < object.cost) {
        const uint32_t left = spatial_split_apply(&range->count, parts, range->first, range->count,
                                                  range->room, &spatial);
        if (left > 0 && left < range->count)
            return left;
    }
    if (object.axis >= 0)
        return object_split_apply(parts, range->first, range->count, &object);
    return boxes_halve(parts->boxes + range->first, parts->order + range->first, range->count,
                       centers);
}

// Moves parts to a later place; the two may overlap.
static void move_parts(struct part_set *parts, uint32_t from, uint32_t to, uint32_t count)
{
    if (from == to)
        return;
    memmove(&parts->boxes[to], &parts->boxes[from], count * sizeof(*parts->boxes));
    memmove(&parts->order[to], &parts->order[from], count * sizeof(*parts->order));
}

// Builds the subtree of a range. Where it stands and what is in it depends on the range alone, so
// any order of tasks gives the same tree.
static void build_node(struct builder *builder, struct range range)
{
    struct bvh_build_node *node = &builder->nodes[range.node];
    struct box bounds, centers;
    boxes_bound(&bounds, &centers, builder->parts.boxes + range.first, range.count);
    memcpy(node->lo, bounds.lo, sizeof(node->lo));
    memcpy(node->hi, bounds.hi, sizeof(node->hi));
    const uint32_t left_count =
        range.count > 1 ? split_range(builder, &range, &bounds, &centers) : 0;
    if (left_count == 0) {
        node->left = range.first;
        node->count = range.count;
        return;
    }

    // Share out the places: those of the right child move up.
    const uint32_t right_count = range.count - left_count;
    const uint32_t spare = range.room - range.count;
    const uint32_t left_room = left_count + (uint32_t)((uint64_t)spare * left_count / range.count);
    move_parts(&builder->parts, range.first + left_count, range.first + left_room, right_count);

    // One pair of places is for the children; they share out the others by their room.
    node->left = 1 + 2 * range.pair;
    node->count = 0;
    const struct range left = {range.first, left_count,     left_room,
                               node->left,  range.pair + 1, range.depth + 1};
    const struct range right = {range.first + left_room, right_count,
                                range.room - left_room,  node->left + 1,
                                range.pair + left_room,  range.depth + 1};
    if (left.count >= TASK_REFS) {
#pragma omp task
        build_node(builder, left);
    } else {
        build_node(builder, left);
    }
    build_node(builder, right);
}

// Loads the references and finds the surface above which an overlap matters.
static void load_refs(struct builder *builder, const struct tri_ref *refs, uint32_t ref_count)
{
    struct part_set *parts = &builder->parts;
    struct box bounds, centers;
#pragma omp parallel for schedule(static)
    for (uint32_t i = 0; i < ref_count; i++) {
        struct box *box = &parts->boxes[i];
        *box = (struct box){{0.0f}, {0.0f}};
        memcpy(box->lo, refs[i].lo, sizeof(refs[i].lo));
        memcpy(box->hi, refs[i].hi, sizeof(refs[i].hi));
        parts->order[i] = i;
    }
    boxes_bound(&bounds, &centers, parts->boxes, ref_count);
    builder->overlap = SPLIT_ALPHA * box_half_area(bounds.lo, bounds.hi);
}

enum status sbvh_build(struct bvh *out, const struct tri_ref *refs, uint32_t ref_count,
                       const struct geometry *geometry, uint32_t leaf_size)
{
    enum status status = STATUS_OK;
    assert(leaf_size >= 2 && leaf_size <= BVH_LEAF_MAX + 1);
    if (ref_count == 0) {
        *out = (struct bvh){0};
        return STATUS_OK;
    }
    const uint32_t limit = 1u << (31u - BVH_LEAF_BITS);
    const double wanted = ref_count * (1.0 + ALLOWANCE);
    const uint32_t room = wanted < limit ? (uint32_t)wanted : ref_count;
    struct builder builder = {
        .parts = {.boxes = array_alloc(room, sizeof(*builder.parts.boxes)),
                  .order = array_alloc(room, sizeof(*builder.parts.order)),
                  .refs = refs,
                  .geometry = geometry},
        .nodes = array_alloc(2 * (size_t)room, sizeof(*builder.nodes)),
        .leaf_size = leaf_size,
    };
    if (builder.parts.boxes == NULL || builder.parts.order == NULL || builder.nodes == NULL) {
        status =
            status_fail(STATUS_NO_MEMORY, "no memory to build a BVH of %u references", ref_count);
        goto cleanup;
    }

    load_refs(&builder, refs, ref_count);
#pragma omp parallel
#pragma omp single
    build_node(&builder, (struct range){0, ref_count, room, 0, 0, 1});
    status = bvh_take(out, builder.nodes, builder.parts.order);

cleanup:
    free(builder.nodes);
    free(builder.parts.order);
    free(builder.parts.boxes);
    return status;
}
