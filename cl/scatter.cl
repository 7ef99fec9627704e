// Stage 7, scatter: the direction in which a path goes on from its shaded hit.
//
//   in    paths, rays, shades, queue of this bounce
//   out   paths, rays
//   next  compact
//
// Variants: those of lib/bsdf.h.

#include "lib/bsdf.h"
#include "lib/samples.h"

#ifndef WG_SCATTER
#define WG_SCATTER 64 // work items in a group
#endif

#define ROULETTE_DEPTH 2u // bounces before Russian roulette may end a path (thesis section 3.5)

__kernel __attribute__((reqd_work_group_size(WG_SCATTER, 1, 1))) void scatter(
    __constant struct settings *settings, const struct batch batch, const uint bounce,
    __global const struct counters *counters, __global const uint *restrict queue,
    __global const struct shade *restrict shades, __global struct ray *restrict rays,
    __global struct path *restrict paths, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
    const uint i = get_global_id(0);
    if (i >= counters[bounce].active)
        return;
    const uint slot = queue[i];
    const uint bits = as_uint(paths[slot].throughput_bits.w);
    uint next_bits = 0;
    if ((bits & (PATH_SHADED | PATH_NO_BOUNCE)) == PATH_SHADED) {
        const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
        const struct path_place place = samples_place(batch, places, slot);
        const uint4 numbers =
            samples_draw(settings, points, place.pixel, place.sample, bounce, RNG_USE_BSDF, 0);
        const struct bsdf_sample sampled = bsdf_sample(
            &b, (float3)(rng_unit(numbers.x), rng_unit(numbers.y), rng_unit(numbers.z)));
        const float3 throughput = paths[slot].throughput_bits.xyz * sampled.weight;

        // Russian roulette by what is left of the path's weight.
        float survival = 1.0f;
        if (bounce >= ROULETTE_DEPTH) {
            survival = max3(throughput);
            if (settings->quantity == QUANTITY_IRRADIANCE)
                survival *= INV_PI;
            survival = min2(survival, 1.0f);
        }
        if (max3(throughput) > 0.0f && rng_unit(numbers.w) < survival) {
            next_bits = PATH_ALIVE | (sampled.specular ? PATH_SPECULAR : 0u) |
                        (bounce + 1 == settings->depth ? PATH_COLLECT : 0u);
            paths[slot].throughput_bits.xyz = throughput / survival;
            rays[slot].dir = (float4)(sampled.dir, sampled.density);
        }
    }
    paths[slot].throughput_bits.w = as_float(next_bits);
}
