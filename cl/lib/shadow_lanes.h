/**
 * @file
 * Shadow rays of eight paths: drawn side by side, traced one by one.
 */
#ifndef LIB_SHADOW_LANES_H
#define LIB_SHADOW_LANES_H

#include "lib/bsdf_lanes.h"
#include "lib/queue.h"
#include "lib/traverse.h"

#define SHADOW_REACH 0.9999f // part of the way to a light that must be free; the rest is its own

// A shadow ray, and what it brings if the way is free.
struct shadow {
    float3 dir;   // unit
    float reach;  // how far the way has to be free, m
    float3 value; // 0 where there is no ray
};

static inline bool shadow_is_needed(const struct shadow *shadow)
{
    return max3(shadow->value) > 0.0f;
}

// Whether no ray follows that could meet a light.
static inline bool path_is_alone(__global const struct path *path)
{
    return (as_uint(path->throughput_bits.w) & PATH_NO_BOUNCE) != 0;
}

// What a shadow ray from p brings.
static inline float3 shadow_trace(BVH_NODES nodes, const struct traced *scene, const float3 p,
                                  const struct shadow *shadow)
{
    return shadow->value * traverse_light(nodes, scene, p, shadow->dir, shadow->reach);
}

#if SHADE_LANES

struct shadow_lanes {
    float dir_x[LANES], dir_y[LANES], dir_z[LANES];
    float reach[LANES];
    struct lanes3 value; // 0 where there is no ray
};

// Eight hits to light.
struct shadow_lanes_hits {
    uint slots[LANES];
    uint together; // bits of those that are lit side by side, by what is in b
    uint others;   // bits of the rest that is to be lit
    struct bsdf_lanes b;
};

// Goes through a queue by eights: i is the place of the first.
#if PERSISTENT
#define SHADOW_LANES_LOOP(i, head, count)                                                          \
    QUEUE_LOCAL(run);                                                                              \
    for (uint i = queue_first(head, run) * LANES; i < (count); i = queue_next(i, head, run) * LANES)
#else
#define SHADOW_LANES_LOOP(i, head, count) SHADE_LANES_LOOP(i, count)
#endif

// Reads the eight from place `first` of the queue on. Returns whether one is to be lit.
static inline bool shadow_lanes_load(struct shadow_lanes_hits *out, __global const uint *queue,
                                     const uint first, const uint count,
                                     __global const struct ray *rays,
                                     __global const struct path *paths,
                                     __global const struct shade *shades)
{
    const uint used = shade_lanes_slots(out->slots, queue, first, count);
    const lanes_float bits = LANES_WORD(lanes_float, paths, out->slots, .throughput_bits.w);
    const uint shaded = used & lanes_bits((lanes_as_uint(bits) & PATH_SHADED) != 0u);
    if (shaded == 0)
        return false;
    out->together = bsdf_lanes_load(&out->b, out->slots, shaded, rays, paths, shades);
    out->others = shaded & ~out->together;
    return true;
}

// Sets all lanes; those without a ray by the mask bring nothing.
static inline void shadow_lanes_set(struct shadow_lanes *shadows, const struct lanes3 dir,
                                    const lanes_float reach, const struct lanes3 value,
                                    const lanes_int needed)
{
    const lanes_float zero = (lanes_float)(0.0f);
    lanes_store(dir.x, shadows->dir_x);
    lanes_store(dir.y, shadows->dir_y);
    lanes_store(dir.z, shadows->dir_z);
    lanes_store(reach, shadows->reach);
    shadows->value = lanes3_select(needed, value, lanes3_make(zero, zero, zero));
}

// Sets one lane after the others. Returns its bit if the ray is needed.
static inline uint shadow_lanes_set_one(struct shadow_lanes *shadows, const uint lane,
                                        const struct shadow *shadow)
{
    if (!shadow_is_needed(shadow))
        return 0;
    shadows->dir_x[lane] = shadow->dir.x;
    shadows->dir_y[lane] = shadow->dir.y;
    shadows->dir_z[lane] = shadow->dir.z;
    shadows->reach[lane] = shadow->reach;
    shadows->value = lanes3_put(shadows->value, lane, shadow->value);
    return 1u << lane;
}

// The share of light that comes along one of them.
static inline float3 shadow_lanes_share(const struct shadow_lanes *shadows, BVH_NODES nodes,
                                        const struct traced *scene, const uint *slots, const uint k,
                                        __global const struct ray *rays)
{
    return traverse_light(nodes, scene, rays[slots[k]].org.xyz,
                          (float3)(shadows->dir_x[k], shadows->dir_y[k], shadows->dir_z[k]),
                          shadows->reach[k]);
}

// What the shadow rays bring: those of `bits` are traced from the slots' points, others bring
// nothing.
static inline struct lanes3 shadow_lanes_trace(const struct shadow_lanes *shadows, BVH_NODES nodes,
                                               const struct traced *scene, const uint *slots,
                                               uint bits, __global const struct ray *rays)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const struct lanes3 none = {zero, zero, zero};
#if ALPHA
    struct lanes3 shares = none;
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        shares = lanes3_put(shares, k, shadow_lanes_share(shadows, nodes, scene, slots, k, rays));
    }
    return lanes3_mul(shadows->value, shares);
#else
    // All comes or nothing: a bit for each ray is all that lives on while rays are traced.
    uint open = 0;
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        if (shadow_lanes_share(shadows, nodes, scene, slots, k, rays).x > 0.0f)
            open |= 1u << k;
    }
    return lanes3_select(lanes_mask(open), shadows->value, none);
#endif
}

// Adds what came to the paths of the hits.
static inline void shadow_lanes_add(const struct shadow_lanes_hits *hits, const struct lanes3 sum,
                                    __global struct path *paths)
{
    const struct lanes4 radiance = LANES_OF(paths, hits->slots, .radiance_normal);
    const struct lanes3 came = lanes3_mul(hits->b.throughput, sum);
    LANES_STORE(paths, hits->slots, .radiance_normal, hits->together | hits->others,
                lanes4_make(lanes3_add(lanes3_xyz(radiance), came), radiance.w));
}

#endif

#endif
