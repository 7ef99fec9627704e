/**
 * @file
 * The light sampler that the kernels are built for: -D LIGHT_SAMPLER, one of shared/settings.h.
 *
 * nodes, parents and leaves are those of the sampler's own hierarchy: struct light_node for the
 * tree, struct light_bvh_node for importance, nothing for the others.
 */
#ifndef LIB_LIGHT_SAMPLER_H
#define LIB_LIGHT_SAMPLER_H

#include "lib/light.h"
#include "lib/light_bvh.h"
#include "shared/settings.h"

#ifndef LIGHT_SAMPLER
#define LIGHT_SAMPLER LIGHT_SAMPLER_TREE
#endif

// Times that a hit chooses lights.
static inline uint light_round_count(__constant struct settings *settings)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    return settings->light_count;
#else
    return settings->shadow_rays;
#endif
}

// The lights that a hit has chosen in one round.
struct light_choice {
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    struct light_walk walk;
#else
    uint light; // EMITTER_NONE if none, or none is left
    float expected;
#endif
};

// Draws of a walk. On scenes of 400 to 10,000 lights 8 leave 0.4 to 0.75 of the variance that 4
// leave, sample by sample, for paths that take up to 1.7 times as long on a CPU: the more lights,
// the better they pay.
#define LIGHT_WALK_DRAWS ((float)LIGHT_WALK_MOST)

// Chooses the lights of a round.
//
//   normal  unit, of the surface at p
//   bits    32 random bits
static inline void light_choice_begin(struct light_choice *choice,
                                      __constant struct settings *settings,
                                      __global const float4 *nodes, const float3 p,
                                      const float3 normal, const uint round, const uint bits)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    choice->light = round;
    choice->expected = 1.0f;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_UNIFORM
    const uint count = settings->light_count;
    choice->light = min((uint)(rng_unit(bits) * (float)count), count - 1);
    choice->expected = (float)settings->shadow_rays / (float)count;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    if (settings->light_count == 1) { // nothing to choose: a quarter of this stage on CPUs
        light_walk_take_first(&choice->walk);
        return;
    }
    light_walk_begin(&choice->walk, (__global const struct light_bvh_node *)nodes, p, normal,
                     LIGHT_WALK_DRAWS, bits);
#else
    float pmf;
    choice->light = light_tree_draw(&pmf, (__global const struct light_node *)nodes, p, bits);
    choice->expected = pmf * (float)settings->shadow_rays;
#endif
}

// Hands out the next light of a round.
//
//   expected  out: how often, on average, all rounds of a hit at p take this light
// Returns its index, or EMITTER_NONE at the end.
static inline uint light_choice_next(float *expected, struct light_choice *choice,
                                     __constant struct settings *settings,
                                     __global const float4 *nodes, const float3 p,
                                     const float3 normal)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    const uint light = light_walk_next(expected, &choice->walk,
                                       (__global const struct light_bvh_node *)nodes, p, normal);
    *expected *= (float)settings->shadow_rays;
#else
    const uint light = choice->light;
    *expected = choice->expected;
    choice->light = EMITTER_NONE;
#endif
    return light;
}

// How often, on average, all rounds of a hit at p take this light.
static inline float light_expected_count(__constant struct settings *settings,
                                         __global const float4 *nodes, __global const uint *parents,
                                         __global const uint *leaves, const float3 p,
                                         const float3 normal, const uint light)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    return 1.0f;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_UNIFORM
    return (float)settings->shadow_rays / (float)settings->light_count;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    if (settings->light_count == 1)
        return (float)settings->shadow_rays;
    const float share = light_bvh_share((__global const struct light_bvh_node *)nodes, parents,
                                        leaves, p, normal, light);
    return (float)settings->shadow_rays * min2(LIGHT_WALK_DRAWS * share, 1.0f);
#else
    return (float)settings->shadow_rays *
           light_tree_pmf((__global const struct light_node *)nodes, parents, leaves, p, light);
#endif
}

#endif
