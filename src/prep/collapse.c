#include "prep/collapse.h"

#include <assert.h>
#include <float.h>
#include <stdlib.h>

#include "prep/array.h"
#include "prep/box.h"

#define TASK_DEPTH 8u // subtrees nearer to the root are tasks: enough of them for all threads

// The least cost of two subtrees in `slots` places, and how many of them the first one takes.
static float deal(uint32_t *taken, const struct collapse *c, uint32_t left, uint32_t slots)
{
    const float *a = c->choices[left].cost;
    const float *b = c->choices[left + 1].cost;
    const uint32_t most = c->rule.width - 1; // that one of them may take
    float least = FLT_MAX;
    for (uint32_t k = 1; k < slots; k++) {
        if (k > most || slots - k > most)
            continue;
        const float cost = a[k - 1] + b[slots - k - 1];
        if (cost < least) {
            least = cost;
            *taken = k;
        }
    }
    return least;
}

static float leaf_cost(const struct collapse *c, float area, uint32_t refs)
{
    return area * c->rule.block_cost * (float)collapse_blocks(c, refs);
}

// Finds the costs of one node from those of its children (Ylitie et al., equations 1 to 4).
static void choose(struct collapse *c, uint32_t index)
{
    const struct bvh_build_node *node = &c->bvh->nodes[index];
    const uint32_t slots = c->rule.width - 1;
    const float area = (float)box_half_area(node->lo, node->hi);
    struct collapse_choice *choice = &c->choices[index];
    if (node->count > 0) {
        *choice = (struct collapse_choice){.first = node->left, .count = node->count, .leaf = true};
        for (uint32_t k = 0; k < slots; k++)
            choice->cost[k] = leaf_cost(c, area, node->count);
        return;
    }
    uint32_t taken;
    choice->first = c->choices[node->left].first;
    choice->count = c->choices[node->left].count + c->choices[node->left + 1].count;
    const float inner = area * c->rule.node_cost + deal(&taken, c, node->left, c->rule.width);
    const float leaf =
        choice->count <= c->rule.leaf_refs ? leaf_cost(c, area, choice->count) : FLT_MAX;
    choice->leaf = leaf <= inner;
    choice->cost[0] = choice->leaf ? leaf : inner;
    for (uint32_t k = 1; k < slots; k++) {
        const float dealt = deal(&taken, c, node->left, k + 1);
        choice->cost[k] = dealt < choice->cost[k - 1] ? dealt : choice->cost[k - 1];
    }
}

// Finds the costs of a subtree.
static void choose_below(struct collapse *c, uint32_t index, uint32_t depth)
{
    const struct bvh_build_node *node = &c->bvh->nodes[index];
    if (node->count == 0 && depth < TASK_DEPTH) {
#pragma omp task
        choose_below(c, node->left, depth + 1);
        choose_below(c, node->left + 1, depth + 1);
#pragma omp taskwait
    } else if (node->count == 0) {
        choose_below(c, node->left, depth + 1);
        choose_below(c, node->left + 1, depth + 1);
    }
    choose(c, index);
}

enum status collapse_build(struct collapse *out, const struct bvh *bvh,
                           const struct collapse_rule *rule)
{
    assert(rule->width >= 2 && rule->width <= COLLAPSE_WIDTH_MAX);
    struct collapse c = {.bvh = bvh, .rule = *rule};
    c.choices = array_alloc(bvh->node_count, sizeof(*c.choices));
    if (c.choices == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for a BVH of %u nodes", bvh->node_count);
    if (bvh->node_count > 0) {
#pragma omp parallel
#pragma omp single
        choose_below(&c, 0, 0);
    }
    *out = c;
    return STATUS_OK;
}

// Collects the subtrees that take up to `slots` places of a wide node.
static void collect(uint32_t *children, uint32_t *count, const struct collapse *c, uint32_t index,
                    uint32_t slots)
{
    const float *cost = c->choices[index].cost;
    while (slots > 1 && cost[slots - 1] == cost[slots - 2])
        slots--;
    if (slots == 1) {
        children[(*count)++] = index;
        return;
    }
    const uint32_t left = c->bvh->nodes[index].left;
    uint32_t taken = 1;
    deal(&taken, c, left, slots);
    collect(children, count, c, left, taken);
    collect(children, count, c, left + 1, slots - taken);
}

// How likely a ray meets the box of a subtree, over what it costs to look into it: of the orders
// tried (surface of the triangles, of the box, size, distance), the one that finds any hit soonest.
static float promise_of(const struct collapse *c, uint32_t index)
{
    const float area = (float)box_half_area(c->bvh->nodes[index].lo, c->bvh->nodes[index].hi);
    const float cost = c->choices[index].cost[0];
    return cost > 0.0f ? area * area / cost : 0.0f;
}

uint32_t collapse_children(uint32_t *children, const struct collapse *c, uint32_t index)
{
    const uint32_t left = c->bvh->nodes[index].left;
    uint32_t count = 0;
    uint32_t taken = 1;
    deal(&taken, c, left, c->rule.width);
    collect(children, &count, c, left, taken);
    collect(children, &count, c, left + 1, c->rule.width - taken);

    // Sort them, the most promising first.
    float promises[COLLAPSE_WIDTH_MAX];
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t child = children[i];
        const float promise = promise_of(c, child);
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

static uint32_t count_below(uint32_t *blocks, const struct collapse *c, uint32_t index)
{
    const struct collapse_choice *choice = &c->choices[index];
    if (choice->leaf) {
        *blocks += collapse_blocks(c, choice->count);
        return 0;
    }
    uint32_t children[COLLAPSE_WIDTH_MAX];
    const uint32_t count = collapse_children(children, c, index);
    uint32_t nodes = 1;
    for (uint32_t i = 0; i < count; i++)
        nodes += count_below(blocks, c, children[i]);
    return nodes;
}

uint32_t collapse_count(uint32_t *blocks, const struct collapse *c)
{
    return c->bvh->node_count > 0 ? count_below(blocks, c, 0) : 0;
}

void collapse_free(struct collapse *c)
{
    free(c->choices);
    *c = (struct collapse){0};
}
