#include "prep/bvh_pack.h"

#include <assert.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/vec3.h"
#include "prep/woop.h"

// Boxes grow by this part of their largest coordinate, 2 to 4 of its ulps: what a slab test and
// Woop's test may lose by rounding near a box's face.
#define BOX_MARGIN 0x1p-22

// Where the boxes of empty leaves are, m: points, so that slab tests of either form miss them.
// Times the inverse of the least direction that kernels divide by, 1e-20, it is still finite.
#define BOX_NOWHERE 1e17f

#define CHILD_EMPTY (~0) // a leaf of no references

// A child as its parent holds it.
struct child {
    float lo[3], hi[3]; // rounded outwards
    int32_t word;
};

static const struct child empty_child = {{BOX_NOWHERE, BOX_NOWHERE, BOX_NOWHERE},
                                         {BOX_NOWHERE, BOX_NOWHERE, BOX_NOWHERE},
                                         CHILD_EMPTY};

void bvh_grow(float *lo, float *hi, const struct bvh_build_node *node)
{
    double largest = 0.0;
    for (int k = 0; k < 3; k++)
        largest = fmax(largest, fmax(fabs(node->lo[k]), fabs(node->hi[k])));
    const double margin = largest * BOX_MARGIN + FLT_MIN;
    for (int k = 0; k < 3; k++) {
        lo[k] = float_below(node->lo[k] - margin);
        hi[k] = float_above(node->hi[k] + margin);
    }
}

void bvh_woop(struct woop *out, const struct geometry *geometry, uint32_t triangle)
{
    const struct triangle *tri = &geometry->triangles[triangle];
    const uint corner[3] = {tri->v0, tri->v1, tri->v2};
    float p[3][3];
    for (int k = 0; k < 3; k++)
        memcpy(p[k], &geometry->vertices[corner[k]].pos_normal, sizeof(p[k]));
    woop_build(out, p[0], p[1], p[2]);
}

uint32_t bvh_ref_word(const struct geometry *geometry, const struct scene_material *materials,
                      uint32_t triangle)
{
    const struct scene_material *material = &materials[geometry->triangles[triangle].material];
    const bool passes = material->masked || material->blended || scene_material_transmits(material);
    return triangle | (passes ? BVH_REF_ALPHA : 0u);
}

// Where a word stands among others; count if it is none of them.
static uint32_t find_word(const uint32_t *words, uint32_t count, uint32_t word)
{
    uint32_t i = 0;
    while (i < count && words[i] != word)
        i++;
    return i;
}

uint32_t bvh_ref_words(uint32_t *words, uint32_t *places, const struct bvh *bvh, uint32_t first,
                       uint32_t count, const struct tri_ref *refs, const struct geometry *geometry,
                       const struct scene_material *materials)
{
    uint32_t written = 0;
    for (uint32_t i = first; i < first + count; i++) {
        const uint32_t word = bvh_ref_word(geometry, materials, refs[bvh->order[i]].triangle);
        const uint32_t place = find_word(words, written, word);
        if (place == written)
            words[written++] = word;
        if (places != NULL)
            places[i - first] = place;
    }
    return written;
}

enum status bvh_check_limits(const struct bvh *bvh)
{
    if (bvh->depth > BVH_STACK_SIZE)
        return status_fail(STATUS_LIMIT, "the BVH is %u nodes deep, more than %u", bvh->depth,
                           BVH_STACK_SIZE);
    if (bvh->ref_count > 1u << (31u - BVH_LEAF_BITS))
        return status_fail(STATUS_LIMIT, "the BVH has %u references, more than %u", bvh->ref_count,
                           1u << (31u - BVH_LEAF_BITS));
    return STATUS_OK;
}

static void set_node(struct bvh_node *out, const struct child *c0, const struct child *c1)
{
    out->row0 = (float4){c0->lo[0], c0->hi[0], c0->lo[1], c0->hi[1]};
    out->row1 = (float4){c1->lo[0], c1->hi[0], c1->lo[1], c1->hi[1]};
    out->row2 = (float4){c0->lo[2], c0->hi[2], c1->lo[2], c1->hi[2]};
    out->row3 = (float4){0.0f, 0.0f, 0.0f, 0.0f};
    memcpy(&out->row3.x, &c0->word, sizeof(c0->word));
    memcpy(&out->row3.y, &c1->word, sizeof(c1->word));
}

struct packer {
    struct packed_bvh packed;
    const struct bvh *bvh;
    const uint32_t *places; // NULL: references stand in the tree's order
};

// The word of a leaf.
static int32_t leaf_word(const struct packer *p, uint32_t first, uint32_t count)
{
    uint32_t least = p->places != NULL ? p->places[first] : first;
    uint32_t most = p->places != NULL ? least : first + count - 1;
    for (uint32_t i = 1; i < count && p->places != NULL; i++) {
        const uint32_t place = p->places[first + i];
        least = place < least ? place : least;
        most = place > most ? place : most;
    }
    assert(most - least < BVH_LEAF_MAX);
    return ~(int32_t)(least << BVH_LEAF_BITS | (most - least + 1));
}

static struct child pack_subtree(struct packer *p, uint32_t index);

// Packs an inner node and what is below it, depth first. Returns its place.
static int32_t pack_inner(struct packer *p, uint32_t left)
{
    const uint32_t place = p->packed.node_count++;
    const struct child c0 = pack_subtree(p, left);
    const struct child c1 = pack_subtree(p, left + 1);
    set_node(&p->packed.nodes[place], &c0, &c1);
    return (int32_t)place;
}

static struct child pack_subtree(struct packer *p, uint32_t index)
{
    const struct bvh_build_node *node = &p->bvh->nodes[index];
    struct child child;
    bvh_grow(child.lo, child.hi, node);
    child.word =
        node->count > 0 ? leaf_word(p, node->left, node->count) : pack_inner(p, node->left);
    return child;
}

// Fills the reference words and their Woop rows.
static void pack_refs(struct packed_bvh *packed, const struct bvh *bvh, const struct tri_ref *refs,
                      const struct geometry *geometry, const struct scene_material *materials)
{
#pragma omp parallel for schedule(static)
    for (uint32_t i = 0; i < bvh->ref_count; i++) {
        const uint32_t triangle = refs[bvh->order[i]].triangle;
        bvh_woop(&packed->woop[i], geometry, triangle);
        packed->refs[i] = bvh_ref_word(geometry, materials, triangle);
    }
}

// Packs the nodes.
static enum status pack_nodes(struct packer *p)
{
    const struct bvh *bvh = p->bvh;
    const enum status status = bvh_check_limits(bvh);
    if (status != STATUS_OK)
        return status;

    // A tree of n nodes has (n - 1) / 2 inner ones; a root is there in any case.
    const uint32_t inner_count = bvh->node_count > 1 ? (bvh->node_count - 1) / 2 : 1;
    p->packed.nodes = array_alloc(inner_count, sizeof(*p->packed.nodes));
    if (p->packed.nodes == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u nodes", inner_count);
    if (bvh->node_count > 1) {
        pack_inner(p, bvh->nodes[0].left);
    } else {
        const struct child leaf = bvh->node_count == 1 ? pack_subtree(p, 0) : empty_child;
        set_node(&p->packed.nodes[p->packed.node_count++], &leaf, &empty_child);
    }
    return STATUS_OK;
}

enum status bvh_pack_over(struct packed_bvh *out, const struct bvh *bvh, const uint32_t *places)
{
    struct packer p = {.bvh = bvh, .places = places};
    const enum status status = pack_nodes(&p);
    if (status == STATUS_OK)
        *out = p.packed;
    return status;
}

enum status bvh_pack(struct packed_bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                     const struct geometry *geometry, const struct scene_material *materials)
{
    struct packer p = {.bvh = bvh};
    const enum status status = pack_nodes(&p);
    if (status != STATUS_OK)
        return status;
    struct packed_bvh *packed = &p.packed;
    packed->woop = array_alloc(bvh->ref_count, sizeof(*packed->woop));
    packed->refs = array_alloc(bvh->ref_count, sizeof(*packed->refs));
    packed->ref_count = bvh->ref_count;
    if (packed->woop == NULL || packed->refs == NULL) {
        packed_bvh_free(packed);
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u references",
                           bvh->ref_count);
    }
    pack_refs(packed, bvh, refs, geometry, materials);
    *out = *packed;
    return STATUS_OK;
}

void packed_bvh_free(struct packed_bvh *packed)
{
    free(packed->refs);
    free(packed->woop);
    free(packed->nodes);
    *packed = (struct packed_bvh){0};
}
