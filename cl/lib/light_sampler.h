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

// Shadow rays towards lights of the hierarchy at one hit.
static inline uint light_ray_count(__constant struct settings *settings)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    return settings->light_count;
#else
    return settings->shadow_rays;
#endif
}

// Chooses the light of shadow ray `ray`.
//
//   expected  out: how often, on average, the rays of one hit at p take this light
//   normal    unit, of the surface at p
//   bits      32 random bits
// Returns its index, or EMITTER_NONE where no light can contribute.
static inline uint light_draw(float *expected, __constant struct settings *settings,
                              __global const float4 *nodes, const float3 p, const float3 normal,
                              const uint ray, const uint bits)
{
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
    *expected = 1.0f;
    return ray;
#elif LIGHT_SAMPLER == LIGHT_SAMPLER_UNIFORM
    const uint count = settings->light_count;
    *expected = (float)settings->shadow_rays / (float)count;
    return min((uint)(rng_unit(bits) * (float)count), count - 1);
#else
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
    const uint light =
        light_bvh_draw(expected, (__global const struct light_bvh_node *)nodes, p, normal, bits);
#else
    const uint light =
        light_tree_draw(expected, (__global const struct light_node *)nodes, p, bits);
#endif
    *expected *= (float)settings->shadow_rays;
    return light;
#endif
}

// How often, on average, light_draw() for the rays of one hit at p takes this light.
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
    return (float)settings->shadow_rays *
           light_bvh_pmf((__global const struct light_bvh_node *)nodes, parents, leaves, p, normal,
                         light);
#else
    return (float)settings->shadow_rays *
           light_tree_pmf((__global const struct light_node *)nodes, parents, leaves, p, light);
#endif
}

#endif
