/**
 * @file
 * One ray through the compressed 8-wide BVH (shared/bvh_compressed.h): closest hit and any hit from
 * one body. For GPUs, and rays that run apart: it reads least, and computes most, for a ray.
 *
 * Source: H. Ylitie, T. Karras, S. Laine, "Efficient Incoherent Ray Traversal on GPUs Through
 * Compressed Wide BVHs", HPG 2017, sections 3.3 to 4.4: what a ray hits in a node is one word of
 * bits, inner children's above in the order of the ray's octant, references below; the stack holds
 * such words; a warp of which few lanes have references left to test puts them off. Differs from
 * it: the stack lies in private memory; triangles are tested as lib/leaf.h says; lanes fetch rays
 * (lib/trace_refill.h) by how many are there, not by what was lost.
 */
#ifndef LIB_TRAVERSE_COMPRESSED_H
#define LIB_TRAVERSE_COMPRESSED_H

#include "lib/byte_planes.h"
#include "lib/leaf.h"
#include "shared/bvh_compressed.h"

#define BVH_NODES __global const struct compressed_node *restrict

#define WALK_STACK(name) uint2 name[COMPRESSED_STACK_SIZE]

// Lanes below which a warp fetches new rays: an H100 traces bounces in Sponza by it at 23 % more
// rays/s than with a lane for each ray. With 24 or 30 lanes it is 1 % fewer, with 12 it is 7 %.
#define WALK_FEW 28

// References are put off where they keep so small a part of a warp's lanes busy: 20 %, as in the
// paper. A third loses 3 to 5 % of the rays/s there, a tenth 2 %.
#define COMPRESSED_POSTPONE 5 // one part in

// A ray on its way through the tree.
struct walk {
    struct hit hit;        // the best so far; its t shrinks with every hit
    float3 org, dir;       // of the ray
    float3 inverse, shift; // of its slab tests
    float tmin;
    uint octant; // of the direction, bit 0, 1 or 2 set where it runs towards +x, +y or +z
    uint2 group; // children that are hit and yet to visit: first of the inner ones of a node, their
                 // hits above and which of its slots are inner ones below; or first of the
                 // references and their hits; y: 0 at the end
    int top;     // entries of the stack
};

//   stack  groups yet to visit
static inline void walk_begin(struct walk *w, uint2 *stack, const float3 org, const float3 dir,
                              const float tmin, const float tmax)
{
    w->hit.t = tmax;
    w->hit.u = 0.0f;
    w->hit.v = 0.0f;
    w->hit.triangle = HIT_NONE;
    w->org = org;
    w->dir = dir;
    w->inverse = traverse_inverse(dir);
    w->shift = -org * w->inverse;
    w->tmin = tmin;
    w->octant = (w->inverse.x < 0.0f ? 0u : 1u) | (w->inverse.y < 0.0f ? 0u : 2u) |
                (w->inverse.z < 0.0f ? 0u : 4u);
    w->group = (uint2)(0u, 0x80000000u); // the root, as an only child
    w->top = 0;
}

static inline bool walk_is_done(const struct walk *w)
{
    return w->group.y == 0;
}

static inline void walk_idle(struct walk *w)
{
    w->group.y = 0;
}

// The bit of a child if the ray meets its box: see shared/bvh_compressed.h.
static inline uint compressed_hit(const float near_x, const float near_y, const float near_z,
                                  const float far_x, const float far_y, const float far_z,
                                  const float tmin, const float tmax, const uint bits,
                                  const uint place)
{
    const float enter = slab_enter(near_x, near_y, near_z, tmin);
    const float leave = slab_leave(far_x, far_y, far_z, tmax);
    return enter <= leave ? (bits & 7u) << (place & 31u) : 0u;
}

// Of four children, those that the ray hits.
//
//   meta         of the children
//   near, far    bytes of the planes that the ray meets first and last along each axis
//   scale, start of the grid along the ray
static inline uint compressed_hits(const uint meta, const uint3 near, const uint3 far,
                                   const float3 scale, const float3 start, const uint octant,
                                   const float tmin, const float tmax)
{
    const float4 near_x = MULADD(byte_planes(near.x), scale.x, start.x);
    const float4 near_y = MULADD(byte_planes(near.y), scale.y, start.y);
    const float4 near_z = MULADD(byte_planes(near.z), scale.z, start.z);
    const float4 far_x = MULADD(byte_planes_too(far.x), scale.x, start.x);
    const float4 far_y = MULADD(byte_planes_too(far.y), scale.y, start.y);
    const float4 far_z = MULADD(byte_planes_too(far.z), scale.z, start.z);

    // Put inner children, whose meta alone has bits 3 and 4, in the ray's order.
    const uint inner = (meta & (meta << 1)) >> 4 & 0x01010101u;
    const uint places = meta ^ (inner * octant);
    const uint bits = meta >> 5;
    return compressed_hit(near_x.x, near_y.x, near_z.x, far_x.x, far_y.x, far_z.x, tmin, tmax, bits,
                          places) |
           compressed_hit(near_x.y, near_y.y, near_z.y, far_x.y, far_y.y, far_z.y, tmin, tmax,
                          bits >> 8, places >> 8) |
           compressed_hit(near_x.z, near_y.z, near_z.z, far_x.z, far_y.z, far_z.z, tmin, tmax,
                          bits >> 16, places >> 16) |
           compressed_hit(near_x.w, near_y.w, near_z.w, far_x.w, far_y.w, far_z.w, tmin, tmax,
                          bits >> 24, places >> 24);
}

// Visits a node: what the ray hits there becomes the walk's group and references to test.
static inline void compressed_visit(uint2 *group, uint2 *refs, BVH_NODES nodes, const uint index,
                                    const struct walk *w, const float tmax)
{
    const float4 head = nodes[index].head;
    const uint4 links = nodes[index].links;
    const uint4 x = nodes[index].planes[0];
    const uint4 y = nodes[index].planes[1];
    const uint4 z = nodes[index].planes[2];

    // Lay the grid along the ray: t = plane * scale + start.
    const uint packed = as_uint(head.w);
    const float3 inverse = w->inverse;
    const float3 scale =
        (float3)(as_float(packed << 23 & 0x7f800000u), as_float(packed << 15 & 0x7f800000u),
                 as_float(packed << 7 & 0x7f800000u)) *
        inverse;
    const float3 start = MULADD(head.xyz, inverse, w->shift);

    // Intersect the ray with the slabs of all children.
    const bool back_x = inverse.x < 0.0f;
    const bool back_y = inverse.y < 0.0f;
    const bool back_z = inverse.z < 0.0f;
    const uint3 near0 = (uint3)(back_x ? x.z : x.x, back_y ? y.z : y.x, back_z ? z.z : z.x);
    const uint3 far0 = (uint3)(back_x ? x.x : x.z, back_y ? y.x : y.z, back_z ? z.x : z.z);
    const uint3 near1 = (uint3)(back_x ? x.w : x.y, back_y ? y.w : y.y, back_z ? z.w : z.y);
    const uint3 far1 = (uint3)(back_x ? x.y : x.w, back_y ? y.y : y.w, back_z ? z.y : z.w);
    const uint hits =
        compressed_hits(links.z, near0, far0, scale, start, w->octant, w->tmin, tmax) |
        compressed_hits(links.w, near1, far1, scale, start, w->octant, w->tmin, tmax);
    *group = (uint2)(links.x, (hits & COMPRESSED_INNER_HITS) | packed >> 24);
    *refs = (uint2)(links.y, hits & ~COMPRESSED_INNER_HITS);
}

static inline void walk_go(struct walk *w, uint2 *stack, BVH_NODES nodes,
                           const struct traced *scene, const bool any_hit, struct passage *passage,
                           const int mode, const int few)
{
    struct hit hit = w->hit;
    uint2 group = w->group;
    int top = w->top;
    while (group.y != 0) {
        uint2 refs = group; // to test
        if ((group.y & COMPRESSED_INNER_HITS) != 0) {
            // Visit the first inner child, keep the others.
            const uint place = 31u - clz(group.y);
            group.y &= ~(1u << place);
            if ((group.y & COMPRESSED_INNER_HITS) != 0)
                stack[top++] = group;
            const uint slot = (place ^ w->octant) & 7u;
            const uint before = popcount(group.y & ((1u << slot) - 1u));
            compressed_visit(&group, &refs, nodes, group.x + before, w, hit.t);
        } else {
            group.y = 0;
        }

        // Test the references, or put them off.
#if WARP_VOTES
        const int lanes = (int)popcount(warp_here());
#endif
        while (refs.y != 0) {
#if WARP_VOTES
            if ((int)popcount(warp_here()) * COMPRESSED_POSTPONE < lanes) {
                stack[top++] = refs;
                break;
            }
#endif
            const uint place = 31u - clz(refs.y);
            refs.y &= ~(1u << place);
            if (leaf_test_one(&hit, scene, refs.x + place, w->org, w->dir, w->tmin, any_hit,
                              passage, mode)) {
                group.y = 0;
                top = 0;
                break;
            }
        }
        if ((group.y & COMPRESSED_INNER_HITS) == 0)
            group = top > 0 ? stack[--top] : (uint2)(0u);
#if WARP_VOTES
        if (few > 0 && (int)popcount(warp_here()) < few)
            break;
#endif
    }
    w->hit = hit;
    w->group = group;
    w->top = top;
}

#endif
