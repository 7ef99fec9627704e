/**
 * @file
 * One ray through the 8-wide BVH (shared/bvh_wide.h): closest hit and any hit from one body. For
 * CPUs, where one work item uses the vector unit by itself.
 *
 * Source: I. Wald et al., "Embree", SIGGRAPH 2014: single-ray traversal, the boxes' near and far
 * planes picked by the signs of the direction, hit children visited from near to far. Differs from
 * it: Woop's test at the leaves.
 */
#ifndef LIB_TRAVERSE_WIDE_H
#define LIB_TRAVERSE_WIDE_H

#include "lib/eight.h"
#include "lib/occluders.h"
#include "lib/prefetch.h"
#include "lib/traced.h"

#define BVH_NODES __global const float8 *restrict

#define WIDE_ROWS       8   // float8 rows of a node
#define WIDE_BLOCK_ROWS 12  // float4 rows of a block
#define WIDE_WORDS      64u // words of 32 bits of a node
#define WIDE_CHILD_WORD 48u // the first of its children's

// Bit k is set where a[k] <= b[k].
static inline uint wide_compare(const float8 a, const float8 b)
{
#if !WIDE_PORTABLE && defined(__AVX512VL__) && defined(__AVX512DQ__)
    return __builtin_ia32_cmpps256_mask(a, b, 2, (uchar)0xff); // 2: less or equal
#else
    return bits8(a <= b);
#endif
}

// Bit k is set where lane k is true.
static inline uint wide_bits(const int4 lanes)
{
#if !WIDE_PORTABLE && defined(__SSE__)
    return (uint)__builtin_ia32_movmskps(as_float4(lanes));
#else
    const int4 bits = lanes & (int4)(1, 2, 4, 8);
    const int2 two = bits.lo | bits.hi;
    return (uint)(two.x | two.y);
#endif
}

// The highest bit that is set; some is.
static inline uint wide_highest(const uint bits)
{
    return 31u - clz(bits);
}

// The words of a node's children.
static inline __global const int *wide_children(BVH_NODES nodes, const int node)
{
    return (__global const int *)(nodes + (size_t)node * WIDE_ROWS + 6);
}

// Asks for what a child word names, a node or a leaf's first block: what is kept for later is there
// when its turn comes.
static inline void wide_prefetch(BVH_NODES nodes, __global const float4 *woop, const int word)
{
    const uint block = (uint)~word >> WIDE_LEAF_BITS;
    __global const char *lines =
        word >= 0 ? (__global const char *)(nodes + (size_t)word * WIDE_ROWS)
                  : (__global const char *)(woop + (size_t)block * WIDE_BLOCK_ROWS);
    PREFETCH(lines);
    PREFETCH(lines + 64);
    PREFETCH(lines + 128);
    if (word >= 0)
        PREFETCH(lines + 192);
}

// Tests a leaf's triangles. Returns whether the ray ends there.
static inline bool wide_leaf(struct hit *hit, const struct traced *scene, const int word,
                             const float3 org, const float3 dir, const float tmin,
                             const bool any_hit, struct passage *passage, const int mode)
{
    const uint first = (uint)~word >> WIDE_LEAF_BITS;
    const uint end = first + ((uint)~word & ((1u << WIDE_LEAF_BITS) - 1u));
    for (uint i = first; i < end; i++) {
        __global const float4 *rows = scene->woop + (size_t)i * WIDE_BLOCK_ROWS;

        // Where the ray meets the four planes. For the nearest hit, all rows are read, whether the
        // first ones decide or not: three misses of the cache at once cost less than one after the
        // other. Most tests for any hit end here.
        const float4 org_w =
            MULADD(rows[0], (float4)org.x,
                   MULADD(rows[1], (float4)org.y, MULADD(rows[2], (float4)org.z, rows[3])));
        const float4 dir_w =
            MULADD(rows[0], (float4)dir.x, MULADD(rows[1], (float4)dir.y, rows[2] * dir.z));
        const float4 t = -org_w / dir_w;
        const int4 near = (t > tmin) & (t < hit->t);
        if (any_hit && wide_bits(near) == 0)
            continue;

        // And whether that is within the triangles.
        const float4 x = MULADD(t, (float4)dir.x, (float4)org.x);
        const float4 y = MULADD(t, (float4)dir.y, (float4)org.y);
        const float4 z = MULADD(t, (float4)dir.z, (float4)org.z);
        const float4 u = MULADD(rows[4], x, MULADD(rows[5], y, MULADD(rows[6], z, rows[7])));
        const float4 v = MULADD(rows[8], x, MULADD(rows[9], y, MULADD(rows[10], z, rows[11])));
        uint bits = wide_bits(near & (u >= 0.0f) & (v >= 0.0f) & (u + v <= 1.0f));
        if (bits == 0)
            continue;

        // Take the nearest of those that are there. In the end, its reference names it.
        PREFETCH(scene->refs + WIDE_BLOCK * i);
        float ts[WIDE_BLOCK], us[WIDE_BLOCK], vs[WIDE_BLOCK];
        vstore4(t, 0, ts);
        vstore4(u, 0, us);
        vstore4(v, 0, vs);
        for (; bits != 0; bits &= bits - 1) {
            const uint lane = bits_lowest(bits);
            if (!any_hit && !(ts[lane] < hit->t))
                continue;
#if ALPHA
            const uint ref = scene->refs[WIDE_BLOCK * i + lane];
            if ((ref & BVH_REF_ALPHA) &&
                passage_ask(passage, mode, &scene->surface, ref & BVH_REF_TRIANGLE, us[lane],
                            vs[lane], org, dir))
                continue;
#endif
            hit->t = ts[lane];
            hit->u = us[lane];
            hit->v = vs[lane];
            hit->triangle = WIDE_BLOCK * i + lane;
            if (any_hit)
                return true;
        }
    }
    return false;
}

// A child that is kept for later.
struct wide_entry {
    int word;    // if any hit is looked for, the place of its word
    float enter; // where the ray enters it; not set if any hit is looked for
};

// Takes the nearest of the children that are hit, and keeps the others, the farther the deeper.
//
//   parent  whose children they are
//   bits    those that are hit; some is
//   enter   where
// Returns the word of the one to go on with.
static inline int wide_descend(struct wide_entry *stack, uint *top, BVH_NODES nodes,
                               __global const float4 *woop, const int parent, uint bits,
                               const float8 enter)
{
    __global const int *children = wide_children(nodes, parent);
    uint child = bits_lowest(bits);
    bits &= bits - 1;
    int node = children[child];
    if (bits == 0)
        return node;

    float starts[WIDE_CHILDREN];
    vstore8(enter, 0, starts);
    float start = starts[child];
    const uint base = *top;
    do {
        child = bits_lowest(bits);
        bits &= bits - 1;
        struct wide_entry entry;
        entry.word = children[child];
        wide_prefetch(nodes, woop, entry.word);
        entry.enter = starts[child];
        if (entry.enter < start) {
            const struct wide_entry other = {node, start};
            node = entry.word;
            start = entry.enter;
            entry = other;
        }
        uint place = (*top)++;
        for (; place > base && stack[place - 1].enter < entry.enter; place--)
            stack[place] = stack[place - 1];
        stack[place] = entry;
    } while (bits != 0);
    return node;
}

#if TRACED_KEEPS

// Keeps a reference that has stopped a ray, unless it lets some rays by.
//
//   place  of the word of its leaf
static inline void wide_keep(BVH_NODES nodes, const struct traced *scene, const uint place,
                             const uint ref)
{
#if ALPHA
    if (scene->refs[ref] & BVH_REF_ALPHA)
        return;
#endif
    __global const float4 *block = scene->woop + (size_t)(ref / WIDE_BLOCK) * WIDE_BLOCK_ROWS;
    occluders_keep(scene->kept, (__global const float *)nodes + (place - WIDE_CHILD_WORD),
                   (__global const float *)block + ref % WIDE_BLOCK);
}

#endif

// Finds what the ray hits between tmin and tmax (lib/traverse.h).
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

    struct wide_entry stack[WIDE_STACK_SIZE]; // children yet to visit, nearer ones on top of their
                                              // siblings
    uint top = 0;                             // their number
    int node = 0;                             // current child word
    uint place = 0;                           // for any hit, where that stands
    __global const int *words = (__global const int *)nodes;

    const float3 inverse = traverse_inverse(dir);
    const float3 shift = -org * inverse;
#if TRACED_KEEPS
    if (any_hit && occluders_stop(scene->kept, org, dir, inverse, shift, tmin, tmax)) {
        hit.triangle = 0;
        return hit;
    }
#endif
    const uint near_x = inverse.x < 0.0f ? 1 : 0; // rows that the ray meets first
    const uint near_y = inverse.y < 0.0f ? 3 : 2;
    const uint near_z = inverse.z < 0.0f ? 5 : 4;
    const float8 inverse_x = (float8)inverse.x;
    const float8 inverse_y = (float8)inverse.y;
    const float8 inverse_z = (float8)inverse.z;
    const float8 shift_x = (float8)shift.x;
    const float8 shift_y = (float8)shift.y;
    const float8 shift_z = (float8)shift.z;
    BVH_NODES nodes_x = nodes + near_x; // first row, in root, of those met first, and last
    BVH_NODES nodes_y = nodes + near_y;
    BVH_NODES nodes_z = nodes + near_z;
    BVH_NODES far_x = nodes + (near_x ^ 1);
    BVH_NODES far_y = nodes + (near_y ^ 1);
    BVH_NODES far_z = nodes + (near_z ^ 1);

    for (;;) {
        // Go down until there is a leaf.
        while (node >= 0) {
            const size_t row = (size_t)node * WIDE_ROWS;
            const float8 enter = max8(max8(MULADD(nodes_x[row], inverse_x, shift_x),
                                           MULADD(nodes_y[row], inverse_y, shift_y)),
                                      max8(MULADD(nodes_z[row], inverse_z, shift_z), (float8)tmin));
            const float8 leave = min8(min8(MULADD(far_x[row], inverse_x, shift_x),
                                           MULADD(far_y[row], inverse_y, shift_y)),
                                      min8(MULADD(far_z[row], inverse_z, shift_z), (float8)hit.t));
            uint bits = wide_compare(enter, leave);
            if (bits == 0)
                goto next;

            // For any hit, take the first, and keep the others in order.
            if (any_hit) {
                const uint first = (uint)node * WIDE_WORDS + WIDE_CHILD_WORD;
                for (; (bits & (bits - 1)) != 0; bits ^= 1u << wide_highest(bits)) {
                    place = first + wide_highest(bits);
                    wide_prefetch(nodes, scene->woop, words[place]);
                    stack[top++].word = (int)place;
                }
                place = first + bits_lowest(bits);
                node = words[place];
                continue;
            }

            node = wide_descend(stack, &top, nodes, scene->woop, node, bits, enter);
        }

        if (wide_leaf(&hit, scene, node, org, dir, tmin, any_hit, passage, mode)) {
#if TRACED_KEEPS
            if (any_hit)
                wide_keep(nodes, scene, place, hit.triangle);
#endif
            return traced_name(hit, scene);
        }
    next:
        // Go on with what is kept, but for what lies beyond the hit.
        do {
            if (top == 0)
                return traced_name(hit, scene);
            top--;
        } while (!any_hit && stack[top].enter >= hit.t);
        node = stack[top].word;
        if (any_hit) {
            place = (uint)node;
            node = words[place];
        }
    }
}

#endif
