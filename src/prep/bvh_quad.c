#include "prep/bvh_quad.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/bvh_pack.h"
#include "prep/byte_grid.h"
#include "prep/collapse.h"

#define LEAF_REFS 16u // most references of a subtree that becomes a leaf

// Cost of a test of a triangle, in visits of a node: it is the shorter one, but few lanes of a warp
// do it together.
#define TRIANGLE_COST 2.0f

struct packer {
    struct quad_bvh quad;
    struct collapse collapse; // of the tree; owned
    const struct tri_ref *refs;
    const struct geometry *geometry;
    const struct scene_material *materials;
};

// Puts the boxes of a node on its grid. False if it does not reach.
static bool set_boxes(struct quad_node *out, const struct byte_boxes *boxes)
{
    float origins[3], scales[3];
    unsigned char bytes[3][2 * QUAD_CHILDREN];
    for (int axis = 0; axis < 3; axis++) {
        // Children that are not there end before they begin.
        struct byte_planes planes;
        memset(planes.lo, 0xff, sizeof(planes.lo));
        memset(planes.hi, 0, sizeof(planes.hi));
        if (!byte_grid_lay(&planes, boxes, axis, false))
            return false;
        origins[axis] = planes.origin;
        scales[axis] = planes.scale;
        for (uint32_t i = 0; i < QUAD_CHILDREN; i++) {
            bytes[axis][2 * i] = planes.lo[i];
            bytes[axis][2 * i + 1] = planes.hi[i];
        }
    }
    out->grid = (float4){origins[0], origins[1], origins[2], scales[0]};
    memcpy(out->planes, bytes, sizeof(bytes));
    memcpy((unsigned char *)out->planes + sizeof(bytes), &scales[1], 2 * sizeof(scales[1]));
    return true;
}

// Writes the references of a leaf. Returns its word.
static int32_t pack_leaf(struct packer *p, const struct collapse_choice *choice)
{
    const uint32_t first = p->quad.ref_count;
    uint32_t *places = p->quad.places + choice->first;
    const uint32_t count =
        bvh_ref_words(p->quad.refs + first, places, p->collapse.bvh, choice->first, choice->count,
                      p->refs, p->geometry, p->materials);
    for (uint32_t i = 0; i < choice->count; i++)
        places[i] += first;
    p->quad.ref_count += count;
    return ~(int32_t)(first << BVH_LEAF_BITS | count);
}

static enum status pack_child(int32_t *word, struct packer *p, uint32_t index);

// Writes a node of these children and what is below them, depth first.
static enum status pack_node(int32_t *word, struct packer *p, const uint32_t *children,
                             uint32_t count)
{
    struct byte_boxes boxes = {.count = count};
    const uint32_t place = p->quad.node_count++;
    int32_t words[QUAD_CHILDREN] = {QUAD_EMPTY, QUAD_EMPTY, QUAD_EMPTY, QUAD_EMPTY};
    for (uint32_t i = 0; i < count; i++) {
        bvh_grow(boxes.lo[i], boxes.hi[i], &p->collapse.bvh->nodes[children[i]]);
        const enum status status = pack_child(&words[i], p, children[i]);
        if (status != STATUS_OK)
            return status;
    }
    if (!set_boxes(&p->quad.nodes[place], &boxes))
        return status_fail(STATUS_LIMIT, "the scene is too large for a BVH of bytes; use --bvh "
                                         "binary");
    memcpy(&p->quad.nodes[place].words, words, sizeof(words));
    *word = (int32_t)place;
    return STATUS_OK;
}

static enum status pack_child(int32_t *word, struct packer *p, uint32_t index)
{
    uint32_t children[COLLAPSE_WIDTH_MAX];
    const struct collapse_choice *choice = &p->collapse.choices[index];
    if (!choice->leaf) {
        const uint32_t count = collapse_children(children, &p->collapse, index);
        return pack_node(word, p, children, count);
    }
    *word = pack_leaf(p, choice);
    return STATUS_OK;
}

static enum status pack(struct packer *p)
{
    const struct bvh *bvh = p->collapse.bvh;
    const uint32_t root = 0;
    int32_t word;
    enum status status;
    if (bvh->node_count > 0 && !p->collapse.choices[0].leaf)
        status = pack_child(&word, p, root);
    else
        status = pack_node(&word, p, &root, bvh->node_count > 0 ? 1 : 0);
    if (status != STATUS_OK)
        return status;
#pragma omp parallel for schedule(static)
    for (uint32_t i = 0; i < p->quad.ref_count; i++)
        bvh_woop(&p->quad.woop[i], p->geometry, p->quad.refs[i] & BVH_REF_TRIANGLE);
    return STATUS_OK;
}

enum status quad_bvh_pack(struct quad_bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                          const struct geometry *geometry, const struct scene_material *materials)
{
    static const struct collapse_rule rule = {.width = QUAD_CHILDREN,
                                              .block = 1,
                                              .leaf_refs = LEAF_REFS,
                                              .node_cost = 1.0f,
                                              .block_cost = TRIANGLE_COST};
    struct packer p = {.refs = refs, .geometry = geometry, .materials = materials};
    enum status status = bvh_check_limits(bvh);
    if (status == STATUS_OK)
        status = collapse_build(&p.collapse, bvh, &rule);
    if (status != STATUS_OK)
        return status;

    uint32_t block_count = 0;
    const uint32_t node_count = // a root of one leaf is none of the tree's
        collapse_count(&block_count, &p.collapse) + 1;
    p.quad.nodes = array_alloc(node_count, sizeof(*p.quad.nodes));
    p.quad.woop = array_alloc(bvh->ref_count, sizeof(*p.quad.woop));
    p.quad.refs = array_alloc(bvh->ref_count, sizeof(*p.quad.refs));
    p.quad.places = array_alloc(bvh->ref_count, sizeof(*p.quad.places));
    if (p.quad.nodes == NULL || p.quad.woop == NULL || p.quad.refs == NULL || p.quad.places == NULL)
        status = status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u nodes and %u references",
                             node_count, bvh->ref_count);
    if (status == STATUS_OK)
        status = pack(&p);
    if (status == STATUS_OK)
        *out = p.quad;
    else
        quad_bvh_free(&p.quad);
    collapse_free(&p.collapse);
    return status;
}

void quad_bvh_free(struct quad_bvh *quad)
{
    free(quad->places);
    free(quad->refs);
    free(quad->woop);
    free(quad->nodes);
    *quad = (struct quad_bvh){0};
}
