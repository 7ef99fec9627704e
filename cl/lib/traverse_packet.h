/**
 * @file
 * Sixteen rays that run alike through the 8-wide BVH (shared/bvh_wide.h) at once: what camera rays
 * of neighbours do on CPUs. A node is visited once for all, by the interval that their slab
 * distances lie in; a leaf's triangles are tested one by one, each against all rays.
 *
 *     rays                 one visit of a node
 *     \  \ | /  /          near plane:  least of (plane - org) * inverse over the rays
 *      \  \|/  /           far plane:   greatest of it
 *     +-[box]-[box]-+      a child is entered where least <= greatest: by all rays, or by none
 *
 * Source of the idea: S. Boulos et al., "Packet-based Whitted and Distribution Ray Tracing",
 * Graphics Interface 2007 (interval arithmetic); I. Wald et al., "Embree", SIGGRAPH 2014. Differs
 * from them: no ray is tested against a box by itself.
 *
 * The arithmetic of the leaves is that of lib/traverse_wide.h. A ray's hit does not depend on whom
 * it goes with: of hits at one distance the first reference counts, and nodes are left out only
 * where they are missed by more than rounding.
 */
#ifndef LIB_TRAVERSE_PACKET_H
#define LIB_TRAVERSE_PACKET_H

#include "lib/traverse_wide.h"

// Part of a distance by which a box has to be missed: a hundred times what its slab distances and
// those of hits are off by.
#define PACKET_SLACK 1.5e-5f

// Rays side by side, and what they have hit.
struct packet {
    float16 org_x, org_y, org_z;
    float16 dir_x, dir_y, dir_z;
    float16 tmin;
    float16 t;    // of the nearest hit so far; first the farthest accepted
    float16 u, v; // weights of its triangle's second and third vertex
    uint16 ref;   // its reference; HIT_NONE if there is none
    int16 active; // the rays to trace; directions are of one octant
};

// Bounds of the active rays on one axis.
struct packet_bounds {
    float org_near, org_far; // that make planes met first near, and those met last far
    float inverse_least, inverse_most;
};

static inline float packet_least(const float16 a)
{
    const float8 eight = min8(a.lo, a.hi);
    const float4 four = eight.lo < eight.hi ? eight.lo : eight.hi;
    const float2 two = four.lo < four.hi ? four.lo : four.hi;
    return min2(two.x, two.y);
}

static inline float packet_most(const float16 a)
{
    return -packet_least(-a);
}

// Where no hit of an active ray to come is beyond.
static inline float packet_end(const struct packet *p)
{
    return packet_most(p->active ? p->t : (float16)(0.0f)) * (1.0f + PACKET_SLACK);
}

// Bounds one axis; `some` is the component of one of the active rays' directions.
static inline struct packet_bounds packet_bound(const struct packet *p, const float16 org,
                                                const float16 dir, const float some)
{
    struct packet_bounds out;
    const float16 none = (float16)(FLT_MAX);
    const float org_least = packet_least(p->active ? org : none);
    const float org_most = packet_most(p->active ? org : -none);
    const bool back = some < 0.0f;
    out.org_near = back ? org_least : org_most;
    out.org_far = back ? org_most : org_least;
    out.inverse_least = 1.0f / traverse_safe(packet_most(p->active ? dir : (float16)(some)));
    out.inverse_most = 1.0f / traverse_safe(packet_least(p->active ? dir : (float16)(some)));
    return out;
}

#if ALPHA

// Asks a triangle that lets some rays by. Returns the rays that it stops, of those of `bits`.
//
//   tinted  out: bits of rays that have gone through something coloured are added
static inline uint packet_ask(uint *tinted, const struct packet *p, const struct traced *scene,
                              const uint triangle, uint bits, const float16 u, const float16 v)
{
    float us[RAY_PACKET], vs[RAY_PACKET];
    float org_x[RAY_PACKET], org_y[RAY_PACKET], org_z[RAY_PACKET];
    float dir_x[RAY_PACKET], dir_y[RAY_PACKET], dir_z[RAY_PACKET];
    uint stopped = 0;
    vstore16(u, 0, us);
    vstore16(v, 0, vs);
    vstore16(p->org_x, 0, org_x);
    vstore16(p->org_y, 0, org_y);
    vstore16(p->org_z, 0, org_z);
    vstore16(p->dir_x, 0, dir_x);
    vstore16(p->dir_y, 0, dir_y);
    vstore16(p->dir_z, 0, dir_z);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        struct passage passage;
        passage_init(&passage);
        if (!passage_ask(&passage, PASSAGE_CHANCE, &scene->surface, triangle, us[k], vs[k],
                         (float3)(org_x[k], org_y[k], org_z[k]),
                         (float3)(dir_x[k], dir_y[k], dir_z[k])))
            stopped |= 1u << k;
        *tinted |= passage.tinted ? 1u << k : 0u;
    }
    return stopped;
}

#endif

// Tests a leaf's triangles.
static inline void packet_leaf(struct packet *p, const struct traced *scene, const int word,
                               uint *tinted)
{
    const uint first = ((uint)~word >> WIDE_LEAF_BITS) * WIDE_BLOCK;
    const uint count = ((uint)~word & ((1u << WIDE_LEAF_BITS) - 1u)) * WIDE_BLOCK;
    for (uint ref = first; ref < first + count; ref++) {
        // Value r of the triangle's rows is row[4 r].
        __global const float *row = (__global const float *)scene->woop +
                                    (size_t)(ref / WIDE_BLOCK) * (4 * WIDE_BLOCK_ROWS) +
                                    ref % WIDE_BLOCK;

        // Where the rays meet its plane.
        const float16 org_w = MULADD(
            (float16)row[0], p->org_x,
            MULADD((float16)row[4], p->org_y, MULADD((float16)row[8], p->org_z, (float16)row[12])));
        const float16 dir_w =
            MULADD((float16)row[0], p->dir_x, MULADD((float16)row[4], p->dir_y, row[8] * p->dir_z));
        const float16 t = -org_w / dir_w;
        const int16 near = p->active & (t > p->tmin) & (t <= p->t);
        if (bits16(near) == 0)
            continue;

        // And whether that is within the triangle.
        const float16 x = MULADD(t, p->dir_x, p->org_x);
        const float16 y = MULADD(t, p->dir_y, p->org_y);
        const float16 z = MULADD(t, p->dir_z, p->org_z);
        const float16 u =
            MULADD((float16)row[16], x,
                   MULADD((float16)row[20], y, MULADD((float16)row[24], z, (float16)row[28])));
        const float16 v =
            MULADD((float16)row[32], x,
                   MULADD((float16)row[36], y, MULADD((float16)row[40], z, (float16)row[44])));
        int16 hit =
            near & (u >= 0.0f) & (v >= 0.0f) & (u + v <= 1.0f) & ((t < p->t) | (p->ref > ref));
#if ALPHA
        const uint bits = bits16(hit);
        if (bits != 0 && (scene->refs[ref] & BVH_REF_ALPHA)) {
            const uint stopped =
                packet_ask(tinted, p, scene, scene->refs[ref] & BVH_REF_TRIANGLE, bits, u, v);
            const int16 lanes = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15};
            hit = -(((int16)(int)stopped >> lanes) & 1);
        }
#endif
        p->t = hit ? t : p->t;
        p->u = hit ? u : p->u;
        p->v = hit ? v : p->v;
        p->ref = hit ? (uint16)(ref) : p->ref;
    }
}

// Finds the nearest hit of every active ray.
//
//   tinted  bits of the rays that have gone through something coloured are added
//   some    the direction of one of them
static inline void traverse_packet(uint *tinted, struct packet *p, BVH_NODES nodes,
                                   const struct traced *scene, const float3 some)
{
    struct wide_entry stack[WIDE_STACK_SIZE]; // children yet to visit, nearer ones on top of their
                                              // siblings
    uint top = 0;                             // their number
    int node = 0;                             // current child word
    float end = packet_end(p);                // no hit to come is farther

    const struct packet_bounds x = packet_bound(p, p->org_x, p->dir_x, some.x);
    const struct packet_bounds y = packet_bound(p, p->org_y, p->dir_y, some.y);
    const struct packet_bounds z = packet_bound(p, p->org_z, p->dir_z, some.z);
    const float tmin = packet_least(p->tmin);
    const uint near_x = some.x < 0.0f ? 1 : 0; // rows that the rays meet first
    const uint near_y = some.y < 0.0f ? 3 : 2;
    const uint near_z = some.z < 0.0f ? 5 : 4;

    for (;;) {
        // Go down until there is a leaf.
        while (node >= 0) {
            BVH_NODES rows = nodes + (size_t)node * WIDE_ROWS;
            const float8 x0 = rows[near_x] - x.org_near;
            const float8 y0 = rows[near_y] - y.org_near;
            const float8 z0 = rows[near_z] - z.org_near;
            const float8 x1 = rows[near_x ^ 1] - x.org_far;
            const float8 y1 = rows[near_y ^ 1] - y.org_far;
            const float8 z1 = rows[near_z ^ 1] - z.org_far;
            const float8 enter =
                max8(max8(min8(x0 * x.inverse_least, x0 * x.inverse_most),
                          min8(y0 * y.inverse_least, y0 * y.inverse_most)),
                     max8(min8(z0 * z.inverse_least, z0 * z.inverse_most), (float8)(tmin)));
            const float8 leave = min8(max8(x1 * x.inverse_least, x1 * x.inverse_most),
                                      min8(max8(y1 * y.inverse_least, y1 * y.inverse_most),
                                           max8(z1 * z.inverse_least, z1 * z.inverse_most)));
            const uint bits =
                wide_compare(enter, min8(leave * (1.0f + PACKET_SLACK), (float8)(end)));
            if (bits == 0)
                goto next;
            node = wide_descend(stack, &top, nodes, scene->woop, node, bits, enter);
        }
        packet_leaf(p, scene, node, tinted);
        end = packet_end(p);
    next:
        // Go on with what is kept, but for what lies beyond all hits.
        do {
            if (top == 0)
                return;
            top--;
        } while (stack[top].enter > end);
        node = stack[top].word;
    }
}

#endif
