// Stage 7, scatter: the direction in which a path goes on from its shaded hit.
//
//   in    paths, rays, shades, queue of this bounce
//   out   paths, rays
//   next  compact
//
// Variants: those of lib/bsdf.h. With SHADE_LANES (lib/shade_lanes.h) eight paths go side by side
// where nothing but the Lambert term is left.

#include "lib/bsdf.h"
#include "lib/samples.h"
#include "lib/shade_lanes.h"

#ifndef WG_SCATTER
#define WG_SCATTER (SHADE_LANES ? 1 : 64) // work items in a group
#endif

// The bits of a path that goes on.
static inline uint scatter_flags(__constant struct settings *settings, const uint bounce)
{
    return PATH_ALIVE | (bounce + 1 == settings->depth ? PATH_COLLECT : 0u);
}

static inline void scatter_slot(__constant struct settings *settings, const struct batch batch,
                                const uint bounce, const uint slot,
                                __global const struct shade *restrict shades,
                                __global struct ray *restrict rays,
                                __global struct path *restrict paths,
                                __global const uint4 *restrict points,
                                __global const uint *restrict places)
{
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

        // Russian roulette by what is left of the path's weight (thesis section 3.5).
        float survival = 1.0f;
        if (bounce >= settings->roulette_depth) {
            survival = max3(throughput);
            if (settings->quantity == QUANTITY_IRRADIANCE)
                survival *= INV_PI;
            survival = min2(survival, 1.0f);
        }
        if (max3(throughput) > 0.0f && rng_unit(numbers.w) < survival) {
            next_bits = scatter_flags(settings, bounce) | (sampled.specular ? PATH_SPECULAR : 0u);
            paths[slot].throughput_bits.xyz = throughput / survival;
            rays[slot].dir = (float4)(sampled.dir, sampled.density);
        }
    }
    paths[slot].throughput_bits.w = as_float(next_bits);
}

#if SHADE_LANES

// As scatter_slot(), for those of eight slots that have a bit: all are Lambert, and go on.
static inline void scatter_lanes(__constant struct settings *settings, const struct batch batch,
                                 const uint bounce, const uint *slots, const uint bits,
                                 __global const struct shade *restrict shades,
                                 __global struct ray *restrict rays,
                                 __global struct path *restrict paths,
                                 __global const uint4 *restrict points,
                                 __global const uint *restrict places)
{
    const struct lambert_lanes b = lambert_lanes_load(slots, rays, paths, shades);
    const struct lanes_place place = lanes_place(batch, places, vload8(0, slots));
    const struct lanes_numbers numbers =
        lanes_draw(settings, points, place.pixel, place.sample, bounce, RNG_USE_BSDF, (uint8)(0u));
    const struct lanes3 dir =
        lanes_sample_cosine(b.normal, lanes_unit(numbers.y), lanes_unit(numbers.z));
    const float8 cosine = lanes3_dot(dir, b.normal);
    const int8 above = (cosine > 0.0f) & (lanes3_dot(dir, b.geometric) > 0.0f);
    struct lanes3 throughput = lanes3_mul(b.throughput, b.diffuse);
    const float8 most = lanes3_max(throughput);

    // Russian roulette as there.
    float8 survival = (float8)(1.0f);
    if (bounce >= settings->roulette_depth) {
        survival = settings->quantity == QUANTITY_IRRADIANCE ? most * INV_PI : most;
        survival = min8(survival, (float8)(1.0f));
        throughput = lanes3_scale(throughput, 1.0f / survival);
    }
    const int8 goes = above & (most > 0.0f) & (lanes_unit(numbers.w) < survival);
    const float8 next_bits = as_float8(goes & (int8)(int)scatter_flags(settings, bounce));
    LANES_STORE(paths, slots, .throughput_bits, bits, lanes4_make(throughput, next_bits));
    LANES_STORE(rays, slots, .dir, bits & lanes_bits(goes), lanes4_make(dir, cosine * INV_PI));
}

#endif

__kernel __attribute__((reqd_work_group_size(WG_SCATTER, 1, 1))) void scatter(
    __constant struct settings *settings, const struct batch batch, const uint bounce,
    __global const struct counters *counters, __global const uint *restrict queue,
    __global const struct shade *restrict shades, __global struct ray *restrict rays,
    __global struct path *restrict paths, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
    const uint count = counters[bounce].active;
#if SHADE_LANES
    SHADE_LANES_LOOP(i, count)
    {
        uint slots[LANES];
        uint rest = shade_lanes_slots(slots, queue, i, count);
        const uint lambert = rest & lambert_lanes_are(slots, PATH_SHADED | PATH_NO_BOUNCE,
                                                      PATH_SHADED, paths, shades);
        if (lambert != 0)
            scatter_lanes(settings, batch, bounce, slots, lambert, shades, rays, paths, points,
                          places);
        for (rest &= ~lambert; rest != 0; rest &= rest - 1)
            scatter_slot(settings, batch, bounce, slots[lanes_lowest(rest)], shades, rays, paths,
                         points, places);
    }
#else
    const uint i = get_global_id(0);
    if (i < count)
        scatter_slot(settings, batch, bounce, queue[i], shades, rays, paths, points, places);
#endif
}
