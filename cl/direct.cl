// Stage 5, direct: light from the lights of the tree at every shaded hit, by shadow rays.
//
//   in    rays, paths, shades, queue of this bounce, lights and their tree, BVH
//   out   paths[slot].radiance
//   next  directional
//
// Variants: those of trace; LIGHT_SAMPLER (lib/light_sampler.h).

#include "lib/bsdf.h"
#include "lib/light_sampler.h"
#include "lib/queue.h"
#include "lib/samples.h"
#include "lib/traverse.h"

#define SHADOW_REACH 0.9999f // part of the way to a light that must be free; the rest is its own

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

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void direct(
    TRACED_PARAMETERS, __constant struct settings *settings, const struct batch batch,
    const uint bounce, __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict queue, __global const struct ray *restrict rays,
    __global const struct shade *restrict shades, __global struct path *restrict paths,
    __global struct counters *counters, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
    TRACED_SCENE(scene);
    const uint round_count = light_round_count(settings);
    const uint count = counters[bounce].active;
    uint traced = 0; // shadow rays of this work item
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].direct_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].direct_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        const uint bits = as_uint(paths[slot].throughput_bits.w);
        if (!(bits & PATH_SHADED))
            continue;
        const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
        const float3 p = rays[slot].org.xyz;
        const bool alone = (bits & PATH_NO_BOUNCE) != 0;
        const struct path_place place = samples_place(batch, places, slot);

        float3 sum = (float3)(0.0f); // over the shadow rays
        for (uint round = 0; round < round_count; round++) {
            // Choose lights.
            uint4 numbers = light_numbers(settings, points, place, bounce, round);
            struct light_choice choice;
            light_choice_begin(&choice, settings, light_nodes, p, b.normal, round, numbers.x);
            for (;;) {
                float expected; // times this hit takes this light, on average
                const uint light =
                    light_choice_next(&expected, &choice, settings, light_nodes, p, b.normal);
                if (light == EMITTER_NONE)
                    break;

                    // Draw a point on it, and weigh what comes from there.
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
                numbers = light_place_numbers(settings, points, place, bounce, round, light);
#endif
                const struct light_sample sampled =
                    light_sample(lights, shapes, light, &scene.surface, p, rng_unit(numbers.y),
                                 rng_unit(numbers.z));
                if (max3(sampled.radiance) <= 0.0f)
                    continue;
                float density = 0.0f; // with which a bounce finds this direction
                float3 value = bsdf_eval(&density, &b, sampled.dir) * sampled.radiance;
                if (max3(value) <= 0.0f)
                    continue;
                if (sampled.density > 0.0f) {
                    expected *= sampled.density;
                    if (!alone && sampled.is_hittable)
                        value *= mis_weight(expected, density);
                }

                // Ask whether the way is free.
                traced++;
                sum +=
                    value / expected *
                    traverse_light(nodes, &scene, p, sampled.dir, sampled.distance * SHADOW_REACH);
            }
        }
        paths[slot].radiance_normal.xyz += paths[slot].throughput_bits.xyz * sum;
    }
    if (traced != 0)
        atomic_add(&counters[bounce].shadow_rays, traced);
}
