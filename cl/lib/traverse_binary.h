/**
 * @file
 * One ray through the binary BVH (shared/bvh.h): closest hit and any hit from one body.
 *
 * Source: T. Aila, S. Laine, "Understanding the Efficiency of Ray Traversal on GPUs", HPG 2009: the
 * while-while loop, both siblings tested together, the nearer first; Woop's test at the leaves.
 * Differs from it: the stack lies in private memory; leaves are tested as lib/leaf.h says. Which of
 * two planes the ray meets first is told by products, not by comparisons, of which GPUs can do half
 * as many: an H100 traces primary rays in Sponza at 7 % more rays/s.
 */
#ifndef LIB_TRAVERSE_BINARY_H
#define LIB_TRAVERSE_BINARY_H

#include "lib/leaf.h"
#include "lib/slab.h"

#if NODES_IMAGE
#define BVH_NODES                __read_only image1d_buffer_t
#define BVH_NODE_ROW(nodes, row) read_imagef(nodes, row)
#else
#define BVH_NODES                __global const float4 *restrict
#define BVH_NODE_ROW(nodes, row) (nodes)[row]
#endif

#define TRAVERSE_DONE 0x7fffffff // below every entry of the stack; no node has that number

// Where the ray meets the slab between two planes, along an axis.
#define BINARY_NEAR(lo, hi, axis) slab_near(lo, up.axis, MULADD(hi, down.axis, shift.axis))
#define BINARY_FAR(lo, hi, axis)  MULADD(hi, up.axis, MULADD(lo, down.axis, shift.axis))

// Where plane 0 is met. By the inverse direction as it is rounded, so that whatever the unit, a
// plane through the origin is met where the ray begins: boxes have no margin.
static inline float3 binary_shift(const float3 org, const float3 inverse, const float tmin)
{
    return MULADD(-org, inverse, (float3)(-tmin));
}

// Finds what the ray hits between tmin, 0 at least, and tmax (lib/traverse.h).
static inline struct hit traverse_through(BVH_NODES nodes, const struct traced *scene,
                                          const float3 org, const float3 dir, const float tmin,
                                          const float tmax, const bool any_hit,
                                          struct passage *passage, const int mode)
{
    struct hit hit; // the best so far
    hit.t = tmax;   // shrinks with every hit
    hit.u = 0.0f;
    hit.v = 0.0f;
    hit.triangle = HIT_NONE;

    int stack[BVH_STACK_SIZE]; // child words yet to visit
    stack[0] = TRAVERSE_DONE;
    int top = 0;  // its last entry
    int node = 0; // current child word
    int leaf = 0; // child word of the leaf to test; 0: none, the root is no child

    // A plane that the ray meets from below counts by `up`, from above by `down`; the other is 0.
    float unit = 1.0f / slab_reach(tmax, tmin);
    const float3 inverse = traverse_inverse(dir);
    const float3 none = (float3)(0.0f);
    float3 up = unit * fmax(inverse, none);
    float3 down = unit * fmin(inverse, none);
    float3 shift = binary_shift(org, up + down, tmin * unit);

    while (node != TRAVERSE_DONE || leaf != 0) {
        const uint lanes = LEAF_LANES();

        // Go down until there is a leaf.
        while ((uint)node < (uint)TRAVERSE_DONE) {
            const float4 row0 = BVH_NODE_ROW(nodes, 4 * node + 0);
            const float4 row1 = BVH_NODE_ROW(nodes, 4 * node + 1);
            const float4 row2 = BVH_NODE_ROW(nodes, 4 * node + 2);
            const float4 row3 = BVH_NODE_ROW(nodes, 4 * node + 3);

            // Intersect the ray with both children's slabs.
            const float enter0 =
                slab_enter_unit(BINARY_NEAR(row0.x, row0.y, x), BINARY_NEAR(row0.z, row0.w, y),
                                BINARY_NEAR(row2.x, row2.y, z), BINARY_FAR(row0.x, row0.y, x),
                                BINARY_FAR(row0.z, row0.w, y), BINARY_FAR(row2.x, row2.y, z));
            const float enter1 =
                slab_enter_unit(BINARY_NEAR(row1.x, row1.y, x), BINARY_NEAR(row1.z, row1.w, y),
                                BINARY_NEAR(row2.z, row2.w, z), BINARY_FAR(row1.x, row1.y, x),
                                BINARY_FAR(row1.z, row1.w, y), BINARY_FAR(row2.z, row2.w, z));
            const bool meets0 = enter0 < SLAB_BEYOND;
            const bool meets1 = enter1 < SLAB_BEYOND;
            const int child0 = as_int(row3.x);
            const int child1 = as_int(row3.y);

            // Take the nearer, keep the farther.
            if (meets0 && meets1) {
                const bool swap = enter1 < enter0;
                node = swap ? child1 : child0;
                stack[++top] = swap ? child0 : child1;
            } else if (meets0 || meets1) {
                node = meets0 ? child0 : child1;
            } else {
                node = stack[top--];
            }

#if WARP_VOTES
            // Keep the first leaf, and go on with what is below it on the stack.
            if (node < 0 && leaf == 0) {
                leaf = node;
                node = stack[top--];
            }
            if (LEAF_IS_DUE(leaf, lanes))
                break;
#endif
        }
#if !WARP_VOTES
        if (node != TRAVERSE_DONE) {
            leaf = node;
            node = stack[top--];
        }
#endif

        // Test the leaf, and those right below it on the stack.
        const float before = hit.t;
        while (leaf != 0) {
            if (leaf_test(&hit, scene, leaf, org, dir, tmin, any_hit, passage, mode))
                return traced_name(hit, scene);
            leaf = leaf_rest(leaf);
            if (leaf == 0 && node < 0) {
                leaf = node;
                node = stack[top--];
            }
            if (LEAF_MAY_WAIT(lanes))
                break;
        }
        if (!any_hit && hit.t < before) {
            const float shrink = slab_reach(before, tmin) / slab_reach(hit.t, tmin);
            unit *= shrink;
            up *= shrink;
            down *= shrink;
            shift = binary_shift(org, up + down, tmin * unit);
        }
    }
    return traced_name(hit, scene);
}

#endif
