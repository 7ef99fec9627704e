#include "prep/bvh_wide.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/box.h"
#include "prep/bvh_pack.h"

// Cost of a visit of a node and of a test of a block. Dearer nodes (2) make bounces in Sponza 4 %
// faster and shadow rays 5 % slower there and in a small scene.
#define NODE_COST  1.0f
#define BLOCK_COST 1.0f

#define LEAF_REFS 16u // most references of a subtree that becomes a leaf
#define SLOTS     (WIDE_CHILDREN - 1)
#define EMPTY_EDGE                                                                                 \
    1e17f // m; boxes of no children end before they begin, and times the inverse of
          // the least direction that kernels divide by are still finite

// What is known of a node of the build tree.
struct choice {
    float cost[SLOTS];     // least cost of the subtree as at most 1 .. 7 children of one wide node
    uint32_t first, count; // its references
    bool leaf;             // as one child, it is a leaf
};

struct packer {
    struct wide_bvh wide;
    const struct bvh *bvh;
    const struct tri_ref *refs;
    const struct geometry *geometry;
    const struct scene_material *materials;
    struct choice *choices; // [bvh->node_count]; owned
};

// The least cost of two subtrees in `slots` places, and how many of them the first one takes.
static float deal(uint32_t *taken, const struct choice *a, const struct choice *b, uint32_t slots)
{
    float least = FLT_MAX;
    for (uint32_t k = 1; k < slots; k++) {
        if (k > SLOTS || slots - k > SLOTS)
            continue;
        const float cost = a->cost[k - 1] + b->cost[slots - k - 1];
        if (cost < least) {
            least = cost;
            *taken = k;
        }
    }
    return least;
}

static uint32_t count_blocks(uint32_t refs)
{
    return (refs + WIDE_BLOCK - 1) / WIDE_BLOCK;
}

// Finds the costs of one node from those of its children (Ylitie et al., equations 1 to 4).
static void choose(struct packer *p, uint32_t index)
{
    struct choice *choices = p->choices;
    const struct bvh_build_node *node = &p->bvh->nodes[index];
    struct choice *choice = &choices[index];
    const float area = (float)box_half_area(node->lo, node->hi);
    if (node->count > 0) {
        *choice = (struct choice){.first = node->left, .count = node->count, .leaf = true};
        for (uint32_t k = 0; k < SLOTS; k++)
            choice->cost[k] = area * BLOCK_COST * (float)count_blocks(node->count);
        return;
    }
    const struct choice *left = &choices[node->left];
    const struct choice *right = &choices[node->left + 1];
    uint32_t taken;
    choice->first = left->first;
    choice->count = left->count + right->count;
    const float inner = area * NODE_COST + deal(&taken, left, right, WIDE_CHILDREN);
    const float leaf = choice->count <= LEAF_REFS
                           ? area * BLOCK_COST * (float)count_blocks(choice->count)
                           : FLT_MAX;
    choice->leaf = leaf <= inner;
    choice->cost[0] = choice->leaf ? leaf : inner;
    for (uint32_t k = 1; k < SLOTS; k++) {
        const float dealt = deal(&taken, left, right, k + 1);
        choice->cost[k] = dealt < choice->cost[k - 1] ? dealt : choice->cost[k - 1];
    }
}

// Collects the subtrees that take up to `slots` places of a wide node.
static void collect(uint32_t *children, uint32_t *count, const struct packer *p, uint32_t index,
                    uint32_t slots)
{
    const struct choice *choice = &p->choices[index];
    const uint32_t left = p->bvh->nodes[index].left;
    while (slots > 1 && choice->cost[slots - 1] == choice->cost[slots - 2])
        slots--;
    if (slots == 1) {
        children[(*count)++] = index;
        return;
    }
    uint32_t taken = 1;
    deal(&taken, &p->choices[left], &p->choices[left + 1], slots);
    collect(children, count, p, left, taken);
    collect(children, count, p, left + 1, slots - taken);
}

// How likely a ray meets the box of a subtree, over what it costs to look into it: of the orders
// tried (surface of the triangles, of the box, size, distance), the one that finds any hit soonest.
static float promise_of(const struct packer *p, uint32_t index)
{
    const float area = (float)box_half_area(p->bvh->nodes[index].lo, p->bvh->nodes[index].hi);
    const float cost = p->choices[index].cost[0];
    return cost > 0.0f ? area * area / cost : 0.0f;
}

// The subtrees that become the children of a wide node. Returns how many.
static uint32_t find_children(uint32_t *children, const struct packer *p, uint32_t index)
{
    const uint32_t left = p->bvh->nodes[index].left;
    uint32_t count = 0;
    uint32_t taken = 1;
    deal(&taken, &p->choices[left], &p->choices[left + 1], WIDE_CHILDREN);
    collect(children, &count, p, left, taken);
    collect(children, &count, p, left + 1, WIDE_CHILDREN - taken);

    // Sort them, the most promising first.
    float promises[WIDE_CHILDREN];
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t child = children[i];
        const float promise = promise_of(p, child);
        uint32_t place = i;
        for (; place > 0 && promises[place - 1] < promise; place--) {
            promises[place] = promises[place - 1];
            children[place] = children[place - 1];
        }
        promises[place] = promise;
        children[place] = child;
    }
    return count;
}

static bool is_repeated(const uint32_t *triangles, uint32_t count, uint32_t triangle)
{
    for (uint32_t i = 0; i < count; i++)
        if (triangles[i] == triangle)
            return true;
    return false;
}

// Writes the blocks of a leaf. Returns its word.
static int32_t pack_leaf(struct packer *p, const struct choice *choice)
{
    uint32_t triangles[BVH_LEAF_MAX + LEAF_REFS];
    uint32_t count = 0;
    for (uint32_t i = 0; i < choice->count; i++) {
        const uint32_t triangle = p->refs[p->bvh->order[choice->first + i]].triangle;
        if (!is_repeated(triangles, count, triangle))
            triangles[count++] = triangle;
    }

    const uint32_t first = p->wide.block_count;
    p->wide.block_count += count_blocks(count);
    memset(&p->wide.blocks[first], 0, count_blocks(count) * sizeof(*p->wide.blocks));
    memset(&p->wide.refs[(size_t)first * WIDE_BLOCK], 0xff,
           count_blocks(count) * WIDE_BLOCK * sizeof(*p->wide.refs));
    for (uint32_t i = 0; i < count; i++)
        p->wide.refs[first * WIDE_BLOCK + i] =
            bvh_ref_word(p->geometry, p->materials, triangles[i]);
    return ~(int32_t)(first << WIDE_LEAF_BITS | count_blocks(count));
}

// Writes one child into its column.
static void set_child(struct wide_node *out, uint32_t column, const float *lo, const float *hi,
                      int32_t word)
{
    float *rows = (float *)out->rows;
    for (int k = 0; k < 3; k++) {
        rows[(2 * k) * (int)WIDE_CHILDREN + (int)column] = lo[k];
        rows[(2 * k + 1) * (int)WIDE_CHILDREN + (int)column] = hi[k];
    }
    memcpy(&rows[6 * WIDE_CHILDREN + column], &word, sizeof(word));
}

static int32_t pack_child(struct packer *p, uint32_t index);

// Writes a wide node of these children and what is below them, depth first. Returns its word.
static int32_t pack_node(struct packer *p, const uint32_t *children, uint32_t count)
{
    static const float far[3] = {EMPTY_EDGE, EMPTY_EDGE, EMPTY_EDGE};
    static const float near[3] = {-EMPTY_EDGE, -EMPTY_EDGE, -EMPTY_EDGE};
    const uint32_t place = p->wide.node_count++;
    memset(&p->wide.nodes[place], 0, sizeof(p->wide.nodes[place]));
    for (uint32_t i = 0; i < WIDE_CHILDREN; i++) {
        if (i >= count) {
            set_child(&p->wide.nodes[place], i, far, near, WIDE_EMPTY);
            continue;
        }
        float lo[3], hi[3];
        bvh_grow(lo, hi, &p->bvh->nodes[children[i]]);
        set_child(&p->wide.nodes[place], i, lo, hi, pack_child(p, children[i]));
    }
    return (int32_t)place;
}

static int32_t pack_child(struct packer *p, uint32_t index)
{
    uint32_t children[WIDE_CHILDREN];
    if (p->choices[index].leaf)
        return pack_leaf(p, &p->choices[index]);
    const uint32_t count = find_children(children, p, index);
    return pack_node(p, children, count);
}

// Fills the blocks' rows.
static void pack_rows(struct packer *p)
{
#pragma omp parallel for schedule(static)
    for (uint32_t i = 0; i < p->wide.block_count * WIDE_BLOCK; i++) {
        struct woop woop;
        const float *rows = (const float *)&woop;
        float *block = (float *)p->wide.blocks[i / WIDE_BLOCK].rows;
        if (p->wide.refs[i] == WIDE_NO_REF)
            continue;
        bvh_woop(&woop, p->geometry, p->wide.refs[i] & BVH_REF_TRIANGLE);
        for (uint32_t k = 0; k < 12; k++)
            block[k * WIDE_BLOCK + i % WIDE_BLOCK] = rows[k];
    }
}

// Counts what a subtree takes; of the blocks at most.
static void count_below(struct packer *p, uint32_t index)
{
    const struct choice *choice = &p->choices[index];
    if (choice->leaf) {
        p->wide.block_count += count_blocks(choice->count);
        return;
    }
    uint32_t children[WIDE_CHILDREN];
    const uint32_t count = find_children(children, p, index);
    p->wide.node_count++;
    for (uint32_t i = 0; i < count; i++)
        count_below(p, children[i]);
}

static enum status allocate(struct packer *p)
{
    if (p->bvh->node_count > 0)
        count_below(p, 0);
    const uint32_t node_count = p->wide.node_count + 1; // a root of one leaf is none of the tree's
    const uint32_t block_count = p->wide.block_count;
    p->wide.nodes = array_alloc(node_count, sizeof(*p->wide.nodes));
    p->wide.blocks = array_alloc(block_count, sizeof(*p->wide.blocks));
    p->wide.refs = array_alloc((size_t)block_count * WIDE_BLOCK, sizeof(*p->wide.refs));
    p->wide.node_count = 0;
    p->wide.block_count = 0;
    if (p->wide.nodes == NULL || p->wide.blocks == NULL || p->wide.refs == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u nodes and %u blocks",
                           node_count, block_count);
    return STATUS_OK;
}

enum status wide_bvh_pack(struct wide_bvh *out, const struct bvh *bvh, const struct tri_ref *refs,
                          const struct geometry *geometry, const struct scene_material *materials)
{
    enum status status = bvh_check_limits(bvh);
    if (status != STATUS_OK)
        return status;
    struct packer p = {.bvh = bvh, .refs = refs, .geometry = geometry, .materials = materials};
    p.choices = array_alloc(bvh->node_count, sizeof(*p.choices));
    if (p.choices == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u nodes", bvh->node_count);
    for (uint32_t i = bvh->node_count; i > 0; i--) // children stand behind their parents
        choose(&p, i - 1);

    status = allocate(&p);
    if (status == STATUS_OK) {
        if (bvh->node_count > 0 && !p.choices[0].leaf) {
            pack_child(&p, 0);
        } else {
            const uint32_t root = 0;
            pack_node(&p, &root, bvh->node_count > 0 ? 1 : 0);
        }
        pack_rows(&p);
        *out = p.wide;
    } else {
        wide_bvh_free(&p.wide);
    }
    free(p.choices);
    return status;
}

void wide_bvh_free(struct wide_bvh *wide)
{
    free(wide->refs);
    free(wide->blocks);
    free(wide->nodes);
    *wide = (struct wide_bvh){0};
}
