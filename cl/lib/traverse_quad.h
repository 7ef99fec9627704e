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
 * What binds an H100 here are the units that compare and pick bits, so as little as possible is
 * left to them. Slab tests count along the ray from tmin, 0, to a little past the best hit so far,
 * 1: products are cut off at 0 and 1 for free, where there were two more comparisons a box, and
 * misses are told by a sum and a product. Half of the planes are decoded by products, too. That is
 * 74 such instructions a node where it was 96; with triangles loaded whole (lib/warp.h), primary
 * rays in Sponza are traced at 8 % more rays/s, bounces at 3 to 5 %, shadow rays at 3 %. Tried
 * without gain: sorting the children less (fewer instructions, more visits), a stack in local
 * memory, more or fewer registers, nodes in the order of their surfaces.
 */
#ifndef LIB_TRAVERSE_QUAD_H
#define LIB_TRAVERSE_QUAD_H

#include "lib/byte_planes.h"
#include "lib/leaf.h"
#include "shared/bvh_quad.h"

#define BVH_NODES __global const struct quad_node *restrict

#define QUAD_DONE        0x7fffffff // below every entry of the stack; no node has that number
#define WALK_STACK(name) int name[QUAD_STACK_SIZE]
#define WALK_FEW         20 // 16 and 24 do the same to 2 %

// Where boxes are looked for if a ray has no end, m: boxes at 1e-20 of it still have other numbers
// than their neighbours.
#define QUAD_FAR 1e18f

#define QUAD_BEYOND 0x3f800000u // bits of 1: enter of a child that is not to be visited, or more

// A child to visit.
struct quad_child {
    uint enter; // bits of where the ray enters it, which stand in the order of the values
    int word;
};

static inline bool quad_is_hit(const struct quad_child child)
{
    return child.enter < QUAD_BEYOND;
}

// a * b + c for four planes that the ray meets first, from 0 to 1.
static inline float4 quad_near(const float4 a, const float b, const float c)
{
#if WARP_VOTES
    return (float4)(warp_muladd_unit(a.x, b, c), warp_muladd_unit(a.y, b, c),
                    warp_muladd_unit(a.z, b, c), warp_muladd_unit(a.w, b, c));
#else
    return clamp(MULADD(a, b, c), 0.0f, 1.0f);
#endif
}

// A child, to be visited if the ray meets it between 0 and 1. As integers, floats that are not
// negative stand in the order of their values, and GPUs find the largest of three integers by one
// instruction. A negative one is below them all: if a box is left there, it lies behind.
static inline struct quad_child quad_child(const float near_x, const float near_y,
                                           const float near_z, const float far_x, const float far_y,
                                           const float far_z, const int word)
{
    const float enter = as_float(max(max(as_int(near_x), as_int(near_y)), as_int(near_z)));
    const float leave = as_float(min(min(as_int(far_x), as_int(far_y)), as_int(far_z)));
    struct quad_child child;
#if WARP_VOTES
    // Of one that is missed, however narrowly, the difference times this is beyond 1.
    child.enter = as_uint(MULADD(warp_sub_unit(enter, leave), 1e30f, enter));
#else
    child.enter = enter <= leave ? as_uint(enter) : QUAD_BEYOND;
#endif
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
static inline void quad_keep(int *stack, int *top, const struct quad_child child)
{
    if (quad_is_hit(child))
        stack[++*top] = child.word;
}

// Makes a child that is hit the next, and keeps the one that was before it.
static inline void quad_visit(struct quad_child *next, int *stack, int *top,
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
    float3 inverse, shift; // of its slab tests: quad_reach() is 1
    float tmin;
    int node; // current child word, QUAD_DONE at the end
    int leaf; // child word of the leaf to test; 0: none, the root is no child
    int top;  // of the stack: its last entry
};

// How far past tmin a ray looks for boxes while its best hit is at t: a little more than to there,
// since of hits at one distance the first in the scene counts.
static inline float quad_reach(const float t, const float tmin)
{
    return MULADD(min2(t, QUAD_FAR), 1.00001f, 1e-18f) - tmin;
}

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
    const float unit = 1.0f / quad_reach(tmax, tmin);
    w->inverse = inverse * unit;
    w->shift = (-org * inverse - tmin) * unit;
    w->tmin = tmin;
    w->node = 0;
    w->leaf = 0;
    w->top = 0;
    stack[0] = QUAD_DONE;
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
    struct hit hit = w->hit;
    int node = w->node;
    int leaf = w->leaf;
    int top = w->top;
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
            const float start_x = MULADD(grid.x, inverse.x, shift.x) - scale.x;
            const float start_y = MULADD(grid.y, inverse.y, shift.y) - scale.y;
            const float start_z = MULADD(grid.z, inverse.z, shift.z) - scale.z;

            // Intersect the ray with the slabs of all children.
            const bool back_x = inverse.x < 0.0f;
            const bool back_y = inverse.y < 0.0f;
            const bool back_z = inverse.z < 0.0f;
            const float4 near_x =
                quad_near(byte_planes(back_x ? planes0.y : planes0.x), scale.x, start_x);
            const float4 near_y =
                quad_near(byte_planes(back_y ? planes0.w : planes0.z), scale.y, start_y);
            const float4 near_z =
                quad_near(byte_planes(back_z ? planes1.y : planes1.x), scale.z, start_z);
            const float4 far_x =
                MULADD(byte_planes_too(back_x ? planes0.x : planes0.y), scale.x, start_x);
            const float4 far_y =
                MULADD(byte_planes_too(back_y ? planes0.z : planes0.w), scale.y, start_y);
            const float4 far_z =
                MULADD(byte_planes_too(back_z ? planes1.x : planes1.y), scale.z, start_z);
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
            node = quad_is_hit(next) ? next.word : stack[top--];

            // Keep the first leaf, and go on with what is below it on the stack.
            if (node < 0 && leaf == 0) {
                leaf = node;
                node = stack[top--];
            }
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
            if (leaf == 0 && node < 0) {
                leaf = node;
                node = stack[top--];
            }
            if (LEAF_MAY_WAIT(lanes))
                break;
        }
        if (!any_hit && hit.t < before) {
            const float unit = quad_reach(before, tmin) / quad_reach(hit.t, tmin);
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
