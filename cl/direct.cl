// Stage 5, direct: light from the lights of the tree at every shaded hit, by shadow rays.
//
//   in    rays, paths, shades, queue of this bounce, lights and their tree, BVH
//   out   paths[slot].radiance; if it scatters, what scatter does
//   next  directional or scatter, or if it scatters, trace
//
// Variants: those of trace; LIGHT_SAMPLER (lib/light_sampler.h). With SHADE_LANES
// (lib/shade_lanes.h) shadow rays of eight hits are drawn side by side where nothing but the
// Lambert term is left. If no other light is to come, the stage does the work of scatter, too: what
// that reads is at hand.

#include "lib/light_group.h" // first: it sets WG_TRACE

#include "lib/direct_hit.h"
#include "lib/queue.h"
#include "lib/scatter.h"
#if SHADE_LANES
#include "lib/light_lanes.h"

// One light needs no choice, and that by eight walks is a seventh of this stage.
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
#define DIRECT_HAS_CHOICE(settings) ((settings)->light_count > 1)
#else
#define DIRECT_HAS_CHOICE(settings) true
#endif

// What eight hits choose lights by, and what they have chosen.
struct direct_lanes {
    float p[3][LANES], normal[3][LANES];
    struct light_choice choices[LANES];
    uint only; // bits of hits that are yet to take the only light
    uint light[LANES];
    float8 expected; // times a hit takes its light, on average
};

// Lets those hits that have a bit choose lights.
static inline void direct_lanes_begin(struct direct_lanes *d, __constant struct settings *settings,
                                      __global const float4 *light_nodes,
                                      const struct lambert_lanes *b, uint bits, const uint round,
                                      const uint8 numbers)
{
    d->only = bits;
    if (!DIRECT_HAS_CHOICE(settings))
        return;
    uint number[LANES];
    vstore8(numbers, 0, number);
    vstore8(b->org.x, 0, d->p[0]);
    vstore8(b->org.y, 0, d->p[1]);
    vstore8(b->org.z, 0, d->p[2]);
    vstore8(b->normal.x, 0, d->normal[0]);
    vstore8(b->normal.y, 0, d->normal[1]);
    vstore8(b->normal.z, 0, d->normal[2]);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = lanes_lowest(bits);
        light_choice_begin(
            &d->choices[k], settings, light_nodes, (float3)(d->p[0][k], d->p[1][k], d->p[2][k]),
            (float3)(d->normal[0][k], d->normal[1][k], d->normal[2][k]), round, number[k]);
    }
}

// Takes the next light of those hits that have a bit. Returns bits of those that had one; the
// others take part with the first light.
static inline uint direct_lanes_next(struct direct_lanes *d, __constant struct settings *settings,
                                     __global const float4 *light_nodes, uint bits)
{
    uint drawn = 0;
    uint8 lights = (uint8)(0u);
    d->expected = (float8)(1.0f);
    if (!DIRECT_HAS_CHOICE(settings)) {
        drawn = d->only;
        d->only = 0;
        d->expected = (float8)((float)settings->shadow_rays);
        bits = 0;
    }
    for (; bits != 0; bits &= bits - 1) {
        const uint k = lanes_lowest(bits);
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
    vstore8(lights, 0, d->light);
    return drawn;
}

// As direct_weigh(), for those hits that have a bit: all are Lambert. Returns bits of the rays that
// are needed.
static inline uint direct_weigh_lanes(struct shadow_lanes *out, const struct direct_lanes *d,
                                      __global const struct light *lights,
                                      __global const struct light_shape *shapes,
                                      const struct surface *surface, const uint bits,
                                      const struct lambert_lanes *b, const float8 u0,
                                      const float8 u1)
{
    const struct light_lanes sampled =
        light_lanes_sample(lights, shapes, d->light, bits, surface, b->org, b->geometric, u0, u1);
    const float8 cosine = lanes3_dot(b->normal, sampled.dir);
    const float8 density = cosine * INV_PI; // with which a bounce finds this direction
    struct lanes3 value = lanes3_mul(lanes3_scale(b->diffuse, density), sampled.radiance);
    const int8 needed = (cosine > 0.0f) & (lanes3_dot(b->geometric, sampled.dir) > 0.0f) &
                        (lanes3_max(value) > 0.0f) & lanes_mask(bits);
    const float8 times = sampled.density > 0.0f ? d->expected * sampled.density : d->expected;
    const float8 shared = lanes_mis_weight(times, density) / times;
    value = lanes3_scale(value, sampled.is_hittable & ~b->alone ? shared : 1.0f / times);
    shadow_lanes_set(out, sampled.dir, sampled.distance * SHADOW_REACH, value, needed);
    return lanes_bits(needed);
}

#endif

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void direct(
    TRACED_PARAMETERS, __constant struct settings *settings, const struct batch batch,
    const uint bounce, __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict queue, __global struct ray *restrict rays,
    __global const struct shade *restrict shades, __global struct path *restrict paths,
    __global struct counters *counters, __global const uint4 *restrict points,
    __global const uint *restrict places, SCATTER_PARAMETERS)
{
    TRACED_SCENE(scene);
    const uint count = counters[bounce].active;
    uint traced = 0; // shadow rays of this work item
#if SHADE_LANES
    const uint round_count = light_round_count(settings);
    struct scatter_run going;
    going.count = 0;
    SHADOW_LANES_LOOP(i, &counters[bounce].direct_head, count)
    {
        struct shadow_lanes_hits hits;
        if (!shadow_lanes_load(&hits, queue, i, count, rays, paths, shades))
            continue;
        const struct lanes_place place = lanes_place(batch, places, vload8(0, hits.slots));
        struct lanes3 sum = {0.0f, 0.0f, 0.0f}; // over the shadow rays
        for (uint round = 0; round < round_count; round++) {
            // Choose lights.
#if LIGHT_SAMPLER == LIGHT_SAMPLER_ALL
            const uint8 number = place.sample;
            const uint8 index = (uint8)(round);
#else
            const uint8 number = place.sample * settings->shadow_rays + round;
            const uint8 index = (uint8)(0u);
#endif
            struct lanes_numbers numbers =
                lanes_draw(settings, points, place.pixel, number, bounce, RNG_USE_LIGHT, index);
            struct direct_lanes d;
            uint left = hits.lambert | hits.others; // that have a light left
            direct_lanes_begin(&d, settings, light_nodes, &hits.b, left, round, numbers.x);
            for (;;) {
                left = direct_lanes_next(&d, settings, light_nodes, left);
                if (left == 0)
                    break;

                    // Draw points on them, and weigh what comes from there.
#if LIGHT_SAMPLER == LIGHT_SAMPLER_IMPORTANCE
                numbers = lanes_draw(settings, points, place.pixel, number, bounce, RNG_USE_LIGHT,
                                     vload8(0, d.light) + 1u);
#endif
                const float8 u0 = lanes_unit(numbers.y);
                const float8 u1 = lanes_unit(numbers.z);
                struct shadow_lanes shadows;
                uint open = direct_weigh_lanes(&shadows, &d, lights, shapes, &scene.surface,
                                               left & hits.lambert, &hits.b, u0, u1);
                float s[LANES], t[LANES], expected[LANES];
                vstore8(u0, 0, s);
                vstore8(u1, 0, t);
                vstore8(d.expected, 0, expected);
                for (uint rest = left & hits.others; rest != 0; rest &= rest - 1) {
                    const uint k = lanes_lowest(rest);
                    const uint slot = hits.slots[k];
                    const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
                    const struct shadow shadow =
                        direct_weigh(lights, shapes, &scene.surface, d.light[k], expected[k], &b,
                                     rays[slot].org.xyz, path_is_alone(&paths[slot]), s[k], t[k]);
                    open |= shadow_lanes_set_one(&shadows, k, &shadow);
                }

                // Ask whether the ways are free.
                traced += popcount(open);
                sum = lanes3_add(
                    sum, shadow_lanes_trace(&shadows, nodes, &scene, hits.slots, open, rays));
            }
        }
        shadow_lanes_add(&hits, sum, paths);
        if (scatters != 0)
            scatter_eight(&going, settings, batch, bounce, hits.slots, hits.lambert, hits.others,
                          &hits.b, shades, rays, paths, points, places, counters, queue_out);
    }
    scatter_run_end(&going, counters, bounce, queue_out);
#else
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].direct_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].direct_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        if (!(as_uint(paths[slot].throughput_bits.w) & PATH_SHADED))
            continue;
        traced += direct_hit(nodes, &scene, settings, batch, bounce, lights, shapes, light_nodes,
                             queue, i, rays, shades, paths, points, places);
        if (scatters != 0)
            scatter_one(settings, batch, bounce, direct_slot_again(queue, i), shades, rays, paths,
                        points, places, counters, queue_out);
    }
#endif
    if (traced != 0)
        atomic_add(&counters[bounce].shadow_rays, traced);
}
