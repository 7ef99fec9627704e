/**
 * @file
 * Light from the lights of the tree at one shaded hit, by shadow rays. For cl/direct.cl, and for
 * cl/bounce.cl.
 */
#ifndef LIB_DIRECT_HIT_H
#define LIB_DIRECT_HIT_H

#include "lib/bsdf.h"
#include "lib/light_sampler.h"
#include "lib/samples.h"
#include "lib/shadow_lanes.h"
#include "lib/traverse.h"

#if !SHADE_LANES

// The numbers of a round of choosing lights. Rounds that draw from all lights share one sequence;
// where there is one to each light, each has its own.
static inline uint4 light_numbers(__constant struct settings *settings,
                                  __global const uint4 *restrict points,
                                  const struct path_place place, const uint bounce,
                                  const uint round)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    const uint number = place.sample;
    const uint index = round;
#else
    const uint number = place.sample * settings->shadow_rays + round;
    const uint index = 0;
#endif
    return samples_draw(settings, points, place.pixel, number, bounce, RNG_USE_LIGHT, index);
}

#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE

// The numbers of the place on one of the lights of a round: each light has its own sequence.
static inline uint4 light_place_numbers(__constant struct settings *settings,
                                        __global const uint4 *restrict points,
                                        const struct path_place place, const uint bounce,
                                        const uint round, const uint light)
{
    const uint number = place.sample * settings->shadow_rays + round;
    return samples_draw(settings, points, place.pixel, number, bounce, RNG_USE_LIGHT, light + 1);
}

#endif

#endif

// Draws a point on a chosen light, and weighs what comes from there.
//
//   expected  times the hit takes this light, on average
//   alone     no bounce could find it as well
//   u0, u1    uniform numbers
static inline struct shadow direct_weigh(__global const struct light *lights,
                                         __global const struct light_shape *shapes,
                                         const struct surface *surface, const uint light,
                                         float expected, const struct bsdf *b, const float3 p,
                                         const bool alone, const float u0, const float u1)
{
    struct shadow out;
    out.value = (float3)(0.0f);
    const struct light_sample sampled =
        light_sample(lights, shapes, light, surface, p, b->geometric, u0, u1);
    if (max3(sampled.radiance) <= 0.0f)
        return out;
    float density = 0.0f; // with which a bounce finds this direction
    float3 value = bsdf_eval(&density, b, sampled.dir) * sampled.radiance;
    if (max3(value) <= 0.0f)
        return out;
    if (sampled.density > 0.0f) {
        expected *= sampled.density;
        if (!alone && sampled.is_hittable)
            value *= mis_weight(expected, density);
    }
    out.dir = sampled.dir;
    out.reach = sampled.distance * SHADOW_REACH;
    out.value = value / expected;
    return out;
}

#if !SHADE_LANES

// The slot at a place of the queue, read anew. What is loaded from it is then loaded anew, too, so
// that none of the hit stands in registers while a ray is traced (an H100 renders Sibenik 5 %
// faster, and the Cornell box by one kernel a bounce 49 %).
static inline uint direct_slot_again(__global const uint *queue, const uint i)
{
    return ((volatile __global const uint *)queue)[i];
}

// Lights the hit at a place of the queue. Returns the shadow rays that were traced.
static inline uint direct_hit(
    BVH_NODES nodes, const struct traced *scene, __constant struct settings *settings,
    const struct batch batch, const uint bounce, __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict queue, const uint i, __global const struct ray *restrict rays,
    __global const struct shade *restrict shades, __global struct path *restrict paths,
    __global const uint4 *restrict points, __global const uint *restrict places)
{
    const uint round_count = light_round_count(settings);
    uint traced = 0;
    float3 sum = (float3)(0.0f); // over the shadow rays
    for (uint round = 0; round < round_count; round++) {
        // Choose lights.
        uint slot = direct_slot_again(queue, i);
        uint4 numbers =
            light_numbers(settings, points, samples_place(batch, places, slot), bounce, round);
        struct light_choice choice;
        light_choice_begin(&choice, settings, light_nodes, rays[slot].org.xyz,
                           bsdf_normal(&paths[slot]), round, numbers.x);
        for (;;) {
            slot = direct_slot_again(queue, i);
            const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
            const float3 p = rays[slot].org.xyz;
            float expected; // times this hit takes this light, on average
            const uint light =
                light_choice_next(&expected, &choice, settings, light_nodes, p, b.normal);
            if (light == EMITTER_NONE)
                break;

                // Draw a point on it, and ask whether the way is free.
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
            numbers = light_place_numbers(settings, points, samples_place(batch, places, slot),
                                          bounce, round, light);
#endif
            const struct shadow shadow =
                direct_weigh(lights, shapes, &scene->surface, light, expected, &b, p,
                             path_is_alone(&paths[slot]), rng_unit(numbers.y), rng_unit(numbers.z));
            if (shadow_is_needed(&shadow)) {
                traced++;
                sum += shadow_trace(nodes, scene, p, &shadow);
            }
        }
    }
    const uint slot = direct_slot_again(queue, i);
    paths[slot].radiance_normal.xyz += paths[slot].throughput_bits.xyz * sum;
    return traced;
}

#endif

#endif
