#include "prep/bvh_leaves.h"

#include <string.h>

#include "prep/array.h"
#include "prep/box.h"
#include "shared/bvh.h"

// Sets a node's box to that of the parts of references in its parent's.
static void bound(struct bvh_build_node *node, const struct box *boxes)
{
    struct box bounds, centers;
    boxes_bound(&bounds, &centers, boxes, node->count);
    memcpy(node->lo, bounds.lo, sizeof(node->lo));
    memcpy(node->hi, bounds.hi, sizeof(node->hi));
}

// Makes two leaves of one; children are put behind all nodes.
static void halve(struct bvh *bvh, uint32_t index, const struct tri_ref *refs)
{
    struct bvh_build_node *node = &bvh->nodes[index];
    struct bvh_build_node *left = &bvh->nodes[bvh->node_count];
    struct bvh_build_node *right = left + 1;
    struct box boxes[BVH_LEAF_MAX + 1];
    struct box own = {{0.0f}, {0.0f}};
    struct box bounds, centers;
    uint32_t *order = bvh->order + node->left;

    // A reference may reach out of its leaf, where its triangle was split.
    memcpy(own.lo, node->lo, sizeof(node->lo));
    memcpy(own.hi, node->hi, sizeof(node->hi));
    for (uint32_t i = 0; i < node->count; i++) {
        boxes[i] = (struct box){{0.0f}, {0.0f}};
        memcpy(boxes[i].lo, refs[order[i]].lo, sizeof(node->lo));
        memcpy(boxes[i].hi, refs[order[i]].hi, sizeof(node->hi));
        box_intersect(&boxes[i], &own);
    }
    boxes_bound(&bounds, &centers, boxes, node->count);
    const uint32_t taken = boxes_halve(boxes, order, node->count, &centers);
    *left = (struct bvh_build_node){.left = node->left, .count = taken};
    *right = (struct bvh_build_node){.left = node->left + taken, .count = node->count - taken};
    bound(left, boxes);
    bound(right, boxes + taken);
    node->left = bvh->node_count;
    node->count = 0;
    bvh->node_count += 2;
}

enum status bvh_split_leaves(struct bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                             uint32_t most)
{
    size_t room = bvh->node_count; // each half has a reference at least
    for (uint32_t i = 0; i < bvh->node_count; i++)
        room += bvh->nodes[i].count > most ? 2 * (size_t)bvh->nodes[i].count : 0;
    struct bvh work = *bvh;
    work.nodes = array_alloc(room, sizeof(*work.nodes));
    work.order = array_alloc(bvh->ref_count, sizeof(*work.order));
    enum status status = STATUS_OK;
    if (work.nodes == NULL || work.order == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %zu nodes", room);
    } else if (bvh->node_count == 0) {
        *out = (struct bvh){0};
    } else {
        memcpy(work.nodes, bvh->nodes, bvh->node_count * sizeof(*work.nodes));
        memcpy(work.order, bvh->order, bvh->ref_count * sizeof(*work.order));
        for (uint32_t i = 0; i < work.node_count; i++) // those appended among them
            if (work.nodes[i].count > most)
                halve(&work, i, refs);
        status = bvh_take(out, work.nodes, work.order);
    }
    bvh_free(&work);
    return status;
}
