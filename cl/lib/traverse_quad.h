/**
 * @file
 * One ray through the 4-wide BVH (shared/bvh_quad.h): closest hit and any hit from one body. For
 * GPUs, whose lanes wait for each row of memory that they read: a quad node has four boxes in the
 * rows of two.
 *
 * Source: T. Aila, S. Laine, "Understanding the Efficiency of Ray Traversal on GPUs", HPG 2009: the
 * while-while loop, with leaves put off (lib/leaf.h). Differs from it: four boxes a visit, whose
 * planes are picked by the signs of the direction.
 *
 * An H100 is bound here by how many instructions a node takes, above all of those that compare and
 * pick bits. Slab tests therefore count from 0 to 1 (lib/slab.h); which plane comes first is picked
 * with the byte (lib/byte_planes.h), half of them by products; and the stack is told what to do
 * (lib/word_stack.h): 134 instructions where it was 163, which traces bounces in Sponza at 3 to 5 %
 * more rays/s, shadow rays at 6 to 13 %. Tried without gain: sorting the children less (fewer
 * instructions, more visits), a stack in local memory, more or fewer registers, nodes in the order
 * of their surfaces.
 */
#ifndef LIB_TRAVERSE_QUAD_H
#define LIB_TRAVERSE_QUAD_H

#include "lib/byte_planes.h"
#include "lib/leaf.h"
#include "lib/slab.h"
#include "lib/word_stack.h"
#include "shared/bvh_quad.h"

#define BVH_NODES __global const struct quad_node *restrict

#define QUAD_DONE        0x7fffffff // below every entry of the stack; no node has that number
#define WALK_STACK(name) int name[QUAD_STACK_SIZE]
#define WALK_FEW         20 // 16 and 24 do the same to 2 %

#define QUAD_BEYOND 0x3f800000u // bits of SLAB_BEYOND

// A child to visit.
struct quad_child {
    uint enter; // bits of where the ray enters it, which stand in the order of the values
    int word;
};

static inline bool quad_is_hit(const struct quad_child child)
{
    return child.enter < QUAD_BEYOND;
}

// slab_near() of four planes.
static inline float4 quad_near(const float4 a, const float b, const float c)
{
    return (float4)(slab_near(a.x, b, c), slab_near(a.y, b, c), slab_near(a.z, b, c),
                    slab_near(a.w, b, c));
}

// A child, to be visited if the ray meets it.
static inline struct quad_child quad_child(const float near_x, const float near_y,
                                           const float near_z, const float far_x, const float far_y,
                                           const float far_z, const int word)
{
    struct quad_child child;
    child.enter = as_uint(slab_enter_unit(near_x, near_y, near_z, far_x, far_y, far_z));
    child.word = word;
    return child;
}

// Puts two children in order, the nearer first.
static inline void quad_order(struct quad_child *a, struct quad_child *b)
{
    const bool swap = b->enter < a->enter;
    const int word = swap ? b->word : a->word;
    const uint enter = min(a->enter, b->enter);
    b->word = swap ? a->word : b->word;
    b->enter = max(a->enter, b->enter);
    a->word = word;
    a->enter = enter;
}

// Keeps a child for later if it is hit. Where the ray enters it is forgotten: to keep that, too,
// and leave out what lies beyond a hit found since, saves 8 % of the visits, but an H100 traces
// bounces in Sponza 4 to 9 % slower.
static inline void quad_keep(int *stack, stack_top *top, const struct quad_child child)
{
    stack_push(stack, top, child.word, quad_is_hit(child));
}

// Makes a child that is hit the next, and keeps the one that was before it.
static inline void quad_visit(struct quad_child *next, int *stack, stack_top *top,
                              const struct quad_child child)
{
    if (!quad_is_hit(child))
        return;
    quad_keep(stack, top, *next);
    *next = child;
}

// A ray on its way through the tree.
struct walk {
    struct hit hit;        // the best so far; its t shrinks with every hit
    float3 org, dir;       // of the ray
    float3 inverse, shift; // of its slab tests: slab_reach() of the best hit is 1
    struct byte_pick pick_x, pick_y, pick_z;
    float tmin;
    int node; // current child word, QUAD_DONE at the end
    int leaf; // child word of the leaf to test; 0: none, the root is no child
    stack_top top;
};

//   stack  [QUAD_STACK_SIZE] child words yet to visit
static inline void walk_begin(struct walk *w, int *stack, const float3 org, const float3 dir,
                              const float tmin, const float tmax)
{
    w->hit.t = tmax;
    w->hit.u = 0.0f;
    w->hit.v = 0.0f;
    w->hit.triangle = HIT_NONE;
    w->org = org;
    w->dir = dir;
    const float3 inverse = traverse_inverse(dir);
    const float unit = 1.0f / slab_reach(tmax, tmin);
    w->inverse = inverse * unit;
    w->shift = (-org * inverse - tmin) * unit;
    w->pick_x = byte_pick(inverse.x < 0.0f);
    w->pick_y = byte_pick(inverse.y < 0.0f);
    w->pick_z = byte_pick(inverse.z < 0.0f);
    w->tmin = tmin;
    w->node = 0;
    w->leaf = 0;
    w->top = stack_begin(stack, QUAD_DONE);
}

static inline bool walk_is_done(const struct walk *w)
{
    return w->node == QUAD_DONE && w->leaf == 0;
}

static inline void walk_idle(struct walk *w)
{
    w->node = QUAD_DONE;
    w->leaf = 0;
}

static inline void walk_go(struct walk *w, int *stack, BVH_NODES nodes, const struct traced *scene,
                           const bool any_hit, struct passage *passage, const int mode,
                           const int few)
{
    float3 inverse = w->inverse;
    float3 shift = w->shift;
    const float tmin = w->tmin;
    const struct byte_pick pick_x = w->pick_x;
    const struct byte_pick pick_y = w->pick_y;
    const struct byte_pick pick_z = w->pick_z;
    struct hit hit = w->hit;
    int node = w->node;
    int leaf = w->leaf;
    stack_top top = w->top;
    while (node != QUAD_DONE || leaf != 0) {
        const uint lanes = LEAF_LANES();

        // Go down until there is a leaf.
        while ((uint)node < (uint)QUAD_DONE) {
            const float4 grid = nodes[node].grid;
            const uint4 planes0 = nodes[node].planes[0];
            const uint4 planes1 = nodes[node].planes[1];
            const int4 words = as_int4(nodes[node].words);

            // Lay the grid along the ray: t = plane * scale + start.
            const float3 scale =
                (float3)(grid.w, as_float(planes1.z), as_float(planes1.w)) * inverse;
            const float3 start = MULADD(grid.xyz, inverse, shift);

            // Intersect the ray with the slabs of all children.
            const float4 near_x = quad_near(byte_planes_near(planes0.xy, pick_x), scale.x, start.x);
            const float4 near_y = quad_near(byte_planes_near(planes0.zw, pick_y), scale.y, start.y);
            const float4 near_z = quad_near(byte_planes_near(planes1.xy, pick_z), scale.z, start.z);
            const float4 far_x = MULADD(byte_planes_far(planes0.xy, pick_x), scale.x, start.x);
            const float4 far_y = MULADD(byte_planes_far(planes0.zw, pick_y), scale.y, start.y);
            const float4 far_z = MULADD(byte_planes_far(planes1.xy, pick_z), scale.z, start.z);
            struct quad_child child0 =
                quad_child(near_x.x, near_y.x, near_z.x, far_x.x, far_y.x, far_z.x, words.x);
            struct quad_child child1 =
                quad_child(near_x.y, near_y.y, near_z.y, far_x.y, far_y.y, far_z.y, words.y);
            struct quad_child child2 =
                quad_child(near_x.z, near_y.z, near_z.z, far_x.z, far_y.z, far_z.z, words.z);
            struct quad_child child3 =
                quad_child(near_x.w, near_y.w, near_z.w, far_x.w, far_y.w, far_z.w, words.w);

            // Take the nearest, keep the others, the farther the deeper; for any hit, take them in
            // the node's order.
            struct quad_child next = {QUAD_BEYOND, 0};
            if (any_hit) {
                quad_visit(&next, stack, &top, child3);
                quad_visit(&next, stack, &top, child2);
                quad_visit(&next, stack, &top, child1);
                quad_visit(&next, stack, &top, child0);
            } else {
                quad_order(&child0, &child2);
                quad_order(&child1, &child3);
                quad_order(&child0, &child1);
                quad_order(&child2, &child3);
                quad_order(&child1, &child2);
                quad_keep(stack, &top, child3);
                quad_keep(stack, &top, child2);
                quad_keep(stack, &top, child1);
                next = child0;
            }
            node = stack_pop(stack, &top, next.word, !quad_is_hit(next));

            // Keep the first leaf, and go on with what is below it on the stack.
            const bool keeps = node < 0 && leaf == 0;
            leaf = keeps ? node : leaf;
            node = stack_pop(stack, &top, node, keeps);
            if (LEAF_IS_DUE(leaf, lanes))
                break;
        }

        // Test the leaf, and those right below it on the stack.
        const float before = hit.t;
        while (leaf != 0) {
            if (leaf_test(&hit, scene, leaf, w->org, w->dir, tmin, any_hit, passage, mode)) {
                node = QUAD_DONE;
                leaf = 0;
                break;
            }
            leaf = leaf_rest(leaf);
            const bool goes_on = leaf == 0 && node < 0;
            leaf = goes_on ? node : leaf;
            node = stack_pop(stack, &top, node, goes_on);
            if (LEAF_MAY_WAIT(lanes))
                break;
        }
        if (!any_hit && hit.t < before) {
            const float unit = slab_reach(before, tmin) / slab_reach(hit.t, tmin);
            inverse *= unit;
            shift *= unit;
        }
#if WARP_VOTES
        if (few > 0 && (int)popcount(warp_here()) < few)
            break;
#endif
    }
    w->hit = hit;
    w->inverse = inverse;
    w->shift = shift;
    w->node = node;
    w->leaf = leaf;
    w->top = top;
}

#endif
