// Stage 6, directional: light from directional lights and the environment at every shaded hit, one
// shadow ray each.
//
//   in    rays, paths, shades, queue of this bounce, directional lights, environment, BVH
//   out   paths[slot].radiance
//   next  scatter
//
// Variants: those of trace; ENV_MAP: there is an environment.

#include "lib/bsdf.h"
#include "lib/environment.h"
#include "lib/queue.h"
#include "lib/samples.h"
#include "lib/traverse.h"
#include "shared/light.h"
#include "shared/settings.h"

#if ENV_MAP

// What one sample of the environment sends to a hit, times f cos over density; 0 where nothing.
//
//   dir    out: where from
//   alone  no bounce could find it as well
static inline float3 directional_draw(float3 *dir, const struct bsdf *b,
                                      const struct environment_map map,
                                      __global const float4 *restrict texels,
                                      __global const struct environment_alias *restrict alias,
                                      const bool alone, const uint4 bits)
{
    const struct environment_sample sampled = environment_draw(map, texels, alias, bits);
    float density; // with which a bounce finds this direction
    *dir = sampled.dir;
    const float3 value = bsdf_eval(&density, b, sampled.dir) * sampled.radiance;
    if (max3(value) <= 0.0f || sampled.density <= 0.0f)
        return (float3)(0.0f);
    return value * ((alone ? 1.0f : mis_weight(sampled.density, density)) / sampled.density);
}

#endif

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void directional(
    TRACED_PARAMETERS, __constant struct settings *settings, const uint bounce,
    __global const struct directional_light *restrict lights, __global const uint *restrict queue,
    __global const struct ray *restrict rays, __global const struct shade *restrict shades,
    __global struct path *restrict paths, __global struct counters *counters
#if ENV_MAP
    ,
    const struct batch batch, const struct environment_map map,
    __global const float4 *restrict map_texels,
    __global const struct environment_alias *restrict map_alias,
    __global const uint4 *restrict points, __global const uint *restrict places
#endif
)
{
    TRACED_SCENE(scene);
    const uint light_count = settings->directional_count;
    const uint count = counters[bounce].active;
    uint traced = 0; // shadow rays of this work item
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].directional_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].directional_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        const uint bits = as_uint(paths[slot].throughput_bits.w);
        if (!(bits & PATH_SHADED))
            continue;
        const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
        const float3 p = rays[slot].org.xyz;

        float3 sum = (float3)(0.0f); // over the lights
        for (uint k = 0; k < light_count; k++) {
            const float3 dir = -lights[k].dir.xyz;
            float density; // no bounce can meet a light without extent
            const float3 value = bsdf_eval(&density, &b, dir) * lights[k].color.xyz;
            if (max3(value) <= 0.0f)
                continue;
            traced++;
            sum += value * traverse_light(nodes, &scene, p, dir, FLT_MAX);
        }
#if ENV_MAP
        const struct path_place place = samples_place(batch, places, slot);
        const uint4 numbers = samples_draw(settings, points, place.pixel, place.sample, bounce,
                                           RNG_USE_ENVIRONMENT, 0);
        float3 dir;
        const float3 value = directional_draw(&dir, &b, map, map_texels, map_alias,
                                              (bits & PATH_NO_BOUNCE) != 0, numbers);
        if (max3(value) > 0.0f) {
            traced++;
            sum += value * traverse_light(nodes, &scene, p, dir, FLT_MAX);
        }
#endif
        paths[slot].radiance_normal.xyz += paths[slot].throughput_bits.xyz * sum;
    }
    if (traced != 0)
        atomic_add(&counters[bounce].directional_rays, traced);
}
