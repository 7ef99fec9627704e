#include "prep/bvh_reinsert.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/box.h"
#include "prep/bvh_trial.h"
#include "shared/bvh.h"

// Bounces visit 7 % and primary rays 16 % fewer nodes in Sponza then. Asking every node in ten
// rounds saves 2 % more, and takes five times as long as the builder.
#define ROUNDS      6u
#define SHARE       20u                  // a round asks one node in so many,
#define SHARE_LEAST 1000u                // at least so many, or all
#define BUCKET_BITS 14u                  // sign, exponent and five bits of what follows
#define DEPTH_LIMIT (BVH_STACK_SIZE - 4) // nodes on the longest way down

// Larger boxes are left as they are: sums over a way down would overflow.
#define AREA_LIMIT (FLT_MAX / (2 * BVH_STACK_SIZE)) // m2

#define NOWHERE 0u // place of a subtree that stays: nothing is put beside the root

// A node on the move. Siblings stand side by side, the left one at an odd place.
struct node {
    struct box box;
    float area;      // half surface, m2
    uint32_t left;   // as in struct bvh_build_node
    uint32_t count;  // likewise
    uint32_t parent; // the root's is itself
    uint32_t height; // nodes on the longest way down from here
};

// What would be gained by putting a subtree beside another one.
struct move {
    uint32_t from, to;
    float gain; // half surface of inner nodes, m2
};

struct reinsertion {
    struct node *nodes;  // [node_count]; owned
    struct move *moves;  // [node_count], of which a round uses some; owned
    bool *touched;       // [node_count] by a move of this round; owned
    uint32_t node_count; // odd
};

static inline float half_area(const struct box *box)
{
    const float x = box->hi[0] - box->lo[0];
    const float y = box->hi[1] - box->lo[1];
    const float z = box->hi[2] - box->lo[2];
    return x * y + y * z + z * x;
}

static inline float united_area(const struct box *a, const struct box *b)
{
    struct box both = *a;
    box_unite(&both, b);
    return half_area(&both);
}

static inline uint32_t sibling_of(uint32_t index)
{
    return index % 2 == 1 ? index + 1 : index - 1;
}

// Computes an inner node anew from its children.
static void refit(struct node *nodes, uint32_t index)
{
    struct node *node = &nodes[index];
    const struct node *left = &nodes[node->left];
    node->box = left[0].box;
    box_unite(&node->box, &left[1].box);
    node->area = half_area(&node->box);
    node->height = 1 + (left[0].height > left[1].height ? left[0].height : left[1].height);
}

static void load(struct reinsertion *r, const struct bvh *bvh)
{
    r->nodes[0].parent = 0;
    for (uint32_t i = 0; i < r->node_count; i++) {
        const struct bvh_build_node *from = &bvh->nodes[i];
        struct node *node = &r->nodes[i];
        node->left = from->left;
        node->count = from->count;
        node->height = 1;
        node->box = box_empty;
        memcpy(node->box.lo, from->lo, sizeof(from->lo));
        memcpy(node->box.hi, from->hi, sizeof(from->hi));
        node->area = half_area(&node->box);
        if (node->count == 0)
            r->nodes[node->left].parent = r->nodes[node->left + 1].parent = i;
    }
    for (uint32_t i = r->node_count; i > 0; i--) // children stand behind their parents
        if (r->nodes[i - 1].count == 0)
            refit(r->nodes, i - 1);
}

// Looks for the best place in a subtree.
//
//   saved  what taking the moved one out has gained so far
static void search(struct move *best, const struct node *nodes, uint32_t root, float saved)
{
    struct {
        uint32_t index;
        float saved; // less what the boxes above grow by
    } stack[BVH_STACK_SIZE + 1], entry = {root, saved};
    const struct node *moved = &nodes[best->from];
    uint32_t top = 0;
    for (;;) {
        const struct node *node = &nodes[entry.index];
        const float united = united_area(&node->box, &moved->box);
        if (entry.saved - united > best->gain) {
            best->gain = entry.saved - united;
            best->to = entry.index;
        }
        const float below = entry.saved - (united - node->area);
        if (node->count == 0 && below - moved->area > best->gain) {
            stack[top].index = node->left + 1;
            stack[top++].saved = below;
            entry.index = node->left;
            entry.saved = below;
            continue;
        }
        do {
            if (top == 0)
                return;
            entry.index = stack[--top].index;
            entry.saved = stack[top].saved;
        } while (!(entry.saved - moved->area > best->gain));
    }
}

// Finds where a subtree should be: looks beside all ancestors, from the nearest on.
static struct move find_place(const struct node *nodes, uint32_t from)
{
    struct move best = {from, NOWHERE, 0.0f};
    uint32_t ancestor = nodes[from].parent;
    uint32_t beside = sibling_of(from);
    struct box rest = nodes[beside].box; // the ancestor's without the moved subtree
    float saved = nodes[ancestor].area;  // the parent goes with it
    search(&best, nodes, beside, saved);
    while (ancestor != 0) {
        if (ancestor != nodes[from].parent)
            saved += nodes[ancestor].area - half_area(&rest);
        beside = sibling_of(ancestor);
        ancestor = nodes[ancestor].parent;
        box_unite(&rest, &nodes[beside].box);
        search(&best, nodes, beside, saved);
    }
    return best;
}

// Copies a node to another place; its parent is the place's.
static void put(struct node *nodes, uint32_t to, const struct node *node)
{
    const uint32_t parent = nodes[to].parent;
    nodes[to] = *node;
    nodes[to].parent = parent;
    if (node->count == 0)
        nodes[node->left].parent = nodes[node->left + 1].parent = to;
}

static void refit_up(struct node *nodes, uint32_t index)
{
    for (;; index = nodes[index].parent) {
        refit(nodes, index);
        if (index == 0)
            return;
    }
}

// Makes a move, if what it touches is as it was found.
static void make_move(struct reinsertion *r, const struct move *move)
{
    struct node *nodes = r->nodes;
    const uint32_t beside = sibling_of(move->from);
    const uint32_t parent = nodes[move->from].parent;
    const uint32_t places[] = {move->from,           beside,   parent,
                               nodes[parent].parent, move->to, nodes[move->to].parent};
    for (int i = 0; i < 6; i++)
        if (r->touched[places[i]])
            return;

    // Nothing is put below itself, and no tree becomes too deep.
    uint32_t depth = 1;
    for (uint32_t i = move->to; i != 0; i = nodes[i].parent, depth++)
        if (i == move->from)
            return;
    const struct node moved = nodes[move->from];
    const struct node other = nodes[move->to];
    const uint32_t height = moved.height > other.height ? moved.height : other.height;
    if (depth + height > DEPTH_LIMIT)
        return;
    for (int i = 0; i < 6; i++)
        r->touched[places[i]] = true;

    // The sibling takes its parent's place. The two places that are free then take both subtrees,
    // and a node over them stands where the other one was.
    const struct node left_behind = nodes[beside];
    const uint32_t pair = move->from < beside ? move->from : beside;
    put(nodes, parent, &left_behind);
    nodes[pair].parent = nodes[pair + 1].parent = move->to;
    nodes[move->to].left = pair;
    nodes[move->to].count = 0;
    put(nodes, pair, &other);
    put(nodes, pair + 1, &moved);
    if (parent != 0)
        refit_up(nodes, nodes[parent].parent);
    refit_up(nodes, move->to);
}

// Puts what gains most first.
static int compare_moves(const void *a, const void *b)
{
    const struct move *x = a;
    const struct move *y = b;
    if (x->gain != y->gain)
        return x->gain > y->gain ? -1 : 1;
    return (x->from > y->from) - (x->from < y->from);
}

// The high bits of an area, which stand in the order of the areas.
static inline uint32_t bucket_of(float area)
{
    uint32_t bits;
    memcpy(&bits, &area, sizeof(bits));
    return bits >> (32 - BUCKET_BITS);
}

// Collects the `count` subtrees of the largest boxes, as exactly as buckets tell.
static void collect_largest(struct reinsertion *r, uint32_t count)
{
    uint32_t sizes[1u << BUCKET_BITS] = {0};
    for (uint32_t i = 1; i < r->node_count; i++)
        sizes[bucket_of(r->nodes[i].area)]++;
    uint32_t last = 1u << BUCKET_BITS; // the bucket that the least of them are in
    uint32_t left = count;             // what that one has to give
    while (sizes[--last] < left)
        left -= sizes[last];
    uint32_t found = 0;
    for (uint32_t i = 1; found < count; i++) {
        const uint32_t bucket = bucket_of(r->nodes[i].area);
        if (bucket < last || (bucket == last && left == 0))
            continue;
        left -= bucket == last;
        r->moves[found++].from = i;
    }
}

static void run_round(struct reinsertion *r)
{
    // Ask those with the largest boxes.
    const uint32_t all = r->node_count - 1;
    const uint32_t share = all / SHARE > SHARE_LEAST ? all / SHARE : SHARE_LEAST;
    const uint32_t count = share < all ? share : all;
    collect_largest(r, count);
#pragma omp parallel for schedule(dynamic, 64)
    for (uint32_t i = 0; i < count; i++)
        r->moves[i] = find_place(r->nodes, r->moves[i].from);

    // Move them.
    qsort(r->moves, count, sizeof(*r->moves), compare_moves);
    memset(r->touched, 0, r->node_count * sizeof(*r->touched));
    for (uint32_t i = 0; i < count && r->moves[i].to != NOWHERE; i++)
        make_move(r, &r->moves[i]);
}

// Makes a tree of the nodes again, depth first.
static enum status take(struct bvh *out, const struct reinsertion *r, const uint32_t *order)
{
    struct bvh_build_node *nodes = array_alloc(r->node_count, sizeof(*nodes));
    if (nodes == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u nodes", r->node_count);
    for (uint32_t i = 0; i < r->node_count; i++) {
        const struct node *node = &r->nodes[i];
        nodes[i].left = node->left;
        nodes[i].count = node->count;
        memcpy(nodes[i].lo, node->box.lo, sizeof(nodes[i].lo));
        memcpy(nodes[i].hi, node->box.hi, sizeof(nodes[i].hi));
    }
    const enum status status = bvh_take(out, nodes, order);
    free(nodes);
    return status;
}

enum status bvh_reinsert(struct bvh *bvh, const struct tri_ref *refs,
                         const struct geometry *geometry)
{
    if (bvh->node_count < 5) // fewer can stand in one way only
        return STATUS_OK;
    enum status status = STATUS_OK;
    struct bvh made = {0};
    struct reinsertion r = {
        .nodes = array_alloc(bvh->node_count, sizeof(*r.nodes)),
        .moves = array_alloc(bvh->node_count, sizeof(*r.moves)),
        .touched = array_alloc(bvh->node_count, sizeof(*r.touched)),
        .node_count = bvh->node_count,
    };
    if (r.nodes == NULL || r.moves == NULL || r.touched == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory to improve a BVH of %u nodes",
                             bvh->node_count);
        goto cleanup;
    }
    load(&r, bvh);
    if (!(r.nodes[0].area < AREA_LIMIT))
        goto cleanup;
    for (uint32_t round = 0; round < ROUNDS; round++)
        run_round(&r);
    status = take(&made, &r, bvh->order);

    // Keep what rays find cheaper.
    double old_work, work;
    if (status == STATUS_OK)
        status = bvh_trial(&old_work, bvh, refs, geometry);
    if (status == STATUS_OK)
        status = bvh_trial(&work, &made, refs, geometry);
    if (status == STATUS_OK && work < old_work) {
        const struct bvh old = *bvh;
        *bvh = made;
        made = old;
    }

cleanup:
    bvh_free(&made);
    free(r.touched);
    free(r.moves);
    free(r.nodes);
    return status;
}
