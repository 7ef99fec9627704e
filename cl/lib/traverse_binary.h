/**
 * @file
 * One ray through the binary BVH (shared/bvh.h): closest hit and any hit from one body.
 *
 * Source: T. Aila, S. Laine, "Understanding the Efficiency of Ray Traversal on GPUs", HPG 2009: the
 * while-while loop, both siblings tested together, the nearer first; Woop's test at the leaves.
 * Differs from it: the stack lies in private memory; leaves are tested as lib/leaf.h says.
 */
#ifndef LIB_TRAVERSE_BINARY_H
#define LIB_TRAVERSE_BINARY_H

#include "lib/leaf.h"

#if NODES_IMAGE
#define BVH_NODES                __read_only image1d_buffer_t
#define BVH_NODE_ROW(nodes, row) read_imagef(nodes, row)
#else
#define BVH_NODES                __global const float4 *restrict
#define BVH_NODE_ROW(nodes, row) (nodes)[row]
#endif

#define TRAVERSE_DONE 0x7fffffff // below every entry of the stack; no node has that number

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

    const float3 inverse = traverse_inverse(dir);
    const float3 shift = -org * inverse;

    while (node != TRAVERSE_DONE || leaf != 0) {
        const uint lanes = LEAF_LANES();

        // Go down until there is a leaf.
        while ((uint)node < (uint)TRAVERSE_DONE) {
            const float4 row0 = BVH_NODE_ROW(nodes, 4 * node + 0);
            const float4 row1 = BVH_NODE_ROW(nodes, 4 * node + 1);
            const float4 row2 = BVH_NODE_ROW(nodes, 4 * node + 2);
            const float4 row3 = BVH_NODE_ROW(nodes, 4 * node + 3);

            // Intersect the ray with both children's slabs.
            const float x00 = MULADD(row0.x, inverse.x, shift.x);
            const float x01 = MULADD(row0.y, inverse.x, shift.x);
            const float y00 = MULADD(row0.z, inverse.y, shift.y);
            const float y01 = MULADD(row0.w, inverse.y, shift.y);
            const float z00 = MULADD(row2.x, inverse.z, shift.z);
            const float z01 = MULADD(row2.y, inverse.z, shift.z);
            const float x10 = MULADD(row1.x, inverse.x, shift.x);
            const float x11 = MULADD(row1.y, inverse.x, shift.x);
            const float y10 = MULADD(row1.z, inverse.y, shift.y);
            const float y11 = MULADD(row1.w, inverse.y, shift.y);
            const float z10 = MULADD(row2.z, inverse.z, shift.z);
            const float z11 = MULADD(row2.w, inverse.z, shift.z);
            const float enter0 = slab_enter(min2(x00, x01), min2(y00, y01), min2(z00, z01), tmin);
            const float leave0 = slab_leave(max2(x00, x01), max2(y00, y01), max2(z00, z01), hit.t);
            const float enter1 = slab_enter(min2(x10, x11), min2(y10, y11), min2(z10, z11), tmin);
            const float leave1 = slab_leave(max2(x10, x11), max2(y10, y11), max2(z10, z11), hit.t);
            const bool meets0 = enter0 <= leave0;
            const bool meets1 = enter1 <= leave1;
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

            // Keep the first leaf, and go on with what is below it on the stack.
            if (node < 0 && leaf == 0) {
                leaf = node;
                node = stack[top--];
            }
            if (LEAF_IS_DUE(leaf, lanes))
                break;
        }

        // Test the leaf, and those right below it on the stack.
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
    }
    return traced_name(hit, scene);
}

#endif
