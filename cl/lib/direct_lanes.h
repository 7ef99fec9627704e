/**
 * @file
 * Hits side by side choose lights and draw points on them, on CPUs: for cl/direct.cl and
 * cl/paths.cl.
 */
#ifndef LIB_DIRECT_LANES_H
#define LIB_DIRECT_LANES_H

#include "lib/light_lanes.h"
#include "lib/light_sampler.h"
#include "lib/shadow_lanes.h"

#if SHADE_LANES

// What hits choose lights by, and what they have chosen.
struct direct_lanes {
    float p[3][LANES], normal[3][LANES];
    struct light_choice choices[LANES];
    bool at_once; // they have chosen all at once, and no choices are there;
    uint only;    // then, bits of hits that are yet to take their only light
    uint light[LANES];
    lanes_float expected; // times a hit takes its light, on average
};

// The numbers of a round of choosing lights: light_numbers() of lib/direct_hit.h.
static inline struct lanes_numbers direct_lanes_numbers(__constant struct settings *settings,
                                                        __global const uint4 *restrict points,
                                                        const struct lanes_place place,
                                                        const uint round)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    const lanes_uint number = place.sample;
    const lanes_uint index = (lanes_uint)(round);
#else
    const lanes_uint number = place.sample * settings->shadow_rays + round;
    const lanes_uint index = (lanes_uint)(0u);
#endif
    return lanes_draw(settings, points, place, number, RNG_USE_LIGHT, index);
}

// Those of the places on the lights that were chosen: light_place_numbers() of lib/direct_hit.h.
static inline struct lanes_numbers direct_lanes_place_numbers(__constant struct settings *settings,
                                                              __global const uint4 *restrict points,
                                                              const struct lanes_place place,
                                                              const uint round,
                                                              const struct lanes_numbers chosen,
                                                              const struct direct_lanes *d)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    return lanes_draw(settings, points, place, place.sample * settings->shadow_rays + round,
                      RNG_USE_LIGHT, lanes_load(d->light) + 1u);
#else
    return chosen;
#endif
}

// Chooses for all where that takes no walk. One light needs no choice, and that by a walk of each
// is a seventh of this stage.
static inline bool direct_lanes_choose(struct direct_lanes *d, __constant struct settings *settings,
                                       const uint round, const lanes_uint numbers)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    lanes_store((lanes_uint)(round), d->light);
    d->expected = (lanes_float)(1.0f);
    return true;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_UNIFORM
    const uint count = settings->light_count;
    const lanes_int light = lanes_to_int(lanes_unit(numbers) * (float)count);
    lanes_store(lanes_as_uint(min(light, (lanes_int)((int)count - 1))), d->light);
    d->expected = (lanes_float)((float)settings->shadow_rays / (float)count);
    return true;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    lanes_store((lanes_uint)(0u), d->light);
    d->expected = (lanes_float)((float)settings->shadow_rays);
    return settings->light_count == 1;
#else
    return false;
#endif
}

// Lets those hits that have a bit choose lights.
static inline void direct_lanes_begin(struct direct_lanes *d, __constant struct settings *settings,
                                      __global const float4 *light_nodes,
                                      const struct bsdf_lanes *b, uint bits, const uint round,
                                      const lanes_uint numbers)
{
    d->only = bits;
    d->at_once = direct_lanes_choose(d, settings, round, numbers);
    if (d->at_once)
        return;
    uint number[LANES];
    lanes_store(numbers, number);
    lanes_store(b->org.x, d->p[0]);
    lanes_store(b->org.y, d->p[1]);
    lanes_store(b->org.z, d->p[2]);
    lanes_store(b->normal.x, d->normal[0]);
    lanes_store(b->normal.y, d->normal[1]);
    lanes_store(b->normal.z, d->normal[2]);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        light_choice_begin(
            &d->choices[k], settings, light_nodes, (float3)(d->p[0][k], d->p[1][k], d->p[2][k]),
            (float3)(d->normal[0][k], d->normal[1][k], d->normal[2][k]), round, number[k]);
    }
}

// Takes the next light of those hits that have a bit. Returns bits of those that had one; the
// others take part with some light.
static inline uint direct_lanes_next(struct direct_lanes *d, __constant struct settings *settings,
                                     __global const float4 *light_nodes, uint bits)
{
    if (d->at_once) {
        const uint all = d->only;
        d->only = 0;
        return all;
    }
    uint drawn = 0;
    lanes_uint lights = (lanes_uint)(0u);
    d->expected = (lanes_float)(1.0f);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        float expected;
        const uint light =
            light_choice_next(&expected, &d->choices[k], settings, light_nodes,
                              (float3)(d->p[0][k], d->p[1][k], d->p[2][k]),
                              (float3)(d->normal[0][k], d->normal[1][k], d->normal[2][k]));
        if (light != EMITTER_NONE) {
            lights = lanes_put_word(lights, k, light);
            d->expected = lanes_put(d->expected, k, expected);
            drawn |= 1u << k;
        }
    }
    lanes_store(lights, d->light);
    return drawn;
}

// struct shadow, lane by lane.
struct direct_lanes_shadows {
    struct lanes3 dir, value;
    lanes_float reach;
    lanes_int needed;
};

// As direct_weigh(), for those hits that have a bit.
static inline struct direct_lanes_shadows direct_lanes_weigh(
    const struct direct_lanes *d, __global const struct light *lights,
    __global const struct light_shape *shapes, const struct surface *surface, const uint bits,
    const struct bsdf_lanes *b, const lanes_float u0, const lanes_float u1)
{
    const struct light_lanes sampled =
        light_lanes_sample(lights, shapes, d->light, bits, surface, b->org, b->geometric, u0, u1);
    const lanes_float cosine = lanes3_dot(b->normal, sampled.dir);
    lanes_float density; // with which a bounce finds this direction
    const struct lanes3 value =
        lanes3_mul(bsdf_lanes_eval(&density, b, sampled.dir), sampled.radiance);
    const lanes_float times = sampled.density > 0.0f ? d->expected * sampled.density : d->expected;
    // mis_weight() / times
    const lanes_int is_shared = sampled.is_hittable & ~b->alone;
    const lanes_float shared = is_shared ? MULADD(density, density / times, times) : times;
    struct direct_lanes_shadows out;
    out.dir = sampled.dir;
    out.reach = sampled.distance * SHADOW_REACH;
    out.needed = (cosine > 0.0f) & (lanes3_dot(b->geometric, sampled.dir) > 0.0f) &
                 (lanes3_max(value) > 0.0f) & lanes_mask(bits);
    out.value = lanes3_scale(value, 1.0f / shared);
    return out;
}

#endif

#endif
