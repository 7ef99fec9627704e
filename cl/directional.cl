// Stage 6, directional: light from directional lights and the environment at every shaded hit, one
// shadow ray each.
//
//   in    rays, paths, shades, queue of this bounce, directional lights, environment, BVH
//   out   paths[slot].radiance; if it scatters, what scatter does
//   next  scatter, or if it scatters, trace
//
// Variants: those of trace; ENV_MAP: there is an environment. With SHADE_LANES (lib/shade_lanes.h)
// shadow rays of eight hits are drawn side by side, but for BSDFs that lib/bsdf_lanes.h leaves out.
// The stage does the work of scatter, too, as direct where it is the last.

#include "lib/light_group.h" // first: it sets WG_TRACE

#include "lib/bsdf.h"
#include "lib/environment.h"
#include "lib/queue.h"
#include "lib/samples.h"
#include "lib/scatter.h"
#include "lib/shadow_lanes.h"
#include "lib/traverse.h"
#include "shared/light.h"
#include "shared/settings.h"

// What shadow rays are drawn from: the directional lights, and after them the environment.
#define DIRECTIONAL_LIGHTS                                                                         \
    __constant struct settings *settings, const uint bounce,                                       \
        __global const struct directional_light *restrict lights
#define DIRECTIONAL_NUMBERS                                                                        \
    const struct batch batch, __global const uint4 *restrict points,                               \
        __global const uint *restrict places
#if ENV_MAP
#define DIRECTIONAL_PARAMETERS                                                                     \
    DIRECTIONAL_LIGHTS, DIRECTIONAL_NUMBERS, const struct environment_map map,                     \
        __global const float4 *restrict map_texels,                                                \
        __global const struct environment_alias *restrict map_alias
#define DIRECTIONAL_ARGUMENTS                                                                      \
    settings, bounce, lights, batch, points, places, map, map_texels, map_alias
#define DIRECTIONAL_COUNT(settings) ((settings)->directional_count + 1)
#else
#define DIRECTIONAL_PARAMETERS      DIRECTIONAL_LIGHTS, DIRECTIONAL_NUMBERS
#define DIRECTIONAL_ARGUMENTS       settings, bounce, lights, batch, points, places
#define DIRECTIONAL_COUNT(settings) ((settings)->directional_count)
#endif

// Draws shadow ray k of the hit in a slot.
//
//   alone  no bounce could find the environment as well
static inline struct shadow directional_draw(DIRECTIONAL_PARAMETERS, const uint k, const uint slot,
                                             const struct bsdf *b, const bool alone)
{
    struct shadow out;
    float density; // with which a bounce finds this direction: no light without extent
    out.reach = FLT_MAX;
#if ENV_MAP
    if (k == settings->directional_count) {
        const struct path_place place = samples_place(batch, places, slot);
        const uint4 numbers = samples_draw(settings, points, place.pixel, place.sample, bounce,
                                           RNG_USE_ENVIRONMENT, 0);
        const struct environment_sample sampled =
            environment_draw(map, map_texels, map_alias, numbers);
        out.dir = sampled.dir;
        out.value = bsdf_eval(&density, b, sampled.dir) * sampled.radiance;
        out.value = sampled.density > 0.0f
                        ? out.value * ((alone ? 1.0f : mis_weight(sampled.density, density)) /
                                       sampled.density)
                        : (float3)(0.0f);
        return out;
    }
#endif
    out.dir = -lights[k].dir.xyz;
    out.value = bsdf_eval(&density, b, out.dir) * lights[k].color.xyz;
    return out;
}

#if SHADE_LANES

// As directional_draw(), for those of eight slots that have a bit. Returns bits of the rays that
// are needed.
static inline uint directional_draw_lanes(DIRECTIONAL_PARAMETERS, struct shadow_lanes *out,
                                          const uint k, const uint *slots, const uint bits,
                                          const struct bsdf_lanes *b)
{
    struct lanes3 dir, radiance;
#if ENV_MAP
    lanes_float drawn; // the density of the environment's directions
    if (k == settings->directional_count) {
        const struct lanes_place place = lanes_place(batch, places, lanes_load(slots), bounce);
        const struct lanes_numbers numbers = lanes_draw(settings, points, place, place.sample,
                                                        RNG_USE_ENVIRONMENT, (lanes_uint)(0u));
        uint n[4][LANES];
        float x[LANES], y[LANES], z[LANES], r[LANES], g[LANES], blue[LANES], light[LANES];
        lanes_store(numbers.x, n[0]);
        lanes_store(numbers.y, n[1]);
        lanes_store(numbers.z, n[2]);
        lanes_store(numbers.w, n[3]);
        for (uint lane = 0; lane < LANES; lane++) {
            const struct environment_sample sampled =
                environment_draw(map, map_texels, map_alias,
                                 (uint4)(n[0][lane], n[1][lane], n[2][lane], n[3][lane]));
            x[lane] = sampled.dir.x;
            y[lane] = sampled.dir.y;
            z[lane] = sampled.dir.z;
            r[lane] = sampled.radiance.x;
            g[lane] = sampled.radiance.y;
            blue[lane] = sampled.radiance.z;
            light[lane] = sampled.density;
        }
        dir = lanes3_make(lanes_load(x), lanes_load(y), lanes_load(z));
        radiance = lanes3_make(lanes_load(r), lanes_load(g), lanes_load(blue));
        drawn = lanes_load(light);
    } else
#endif
    {
        const float4 away = -lights[k].dir;
        const float4 color = lights[k].color;
        dir = lanes3_make((lanes_float)(away.x), (lanes_float)(away.y), (lanes_float)(away.z));
        radiance =
            lanes3_make((lanes_float)(color.x), (lanes_float)(color.y), (lanes_float)(color.z));
    }
    lanes_float density; // with which bounces find these directions
    struct lanes3 value = lanes3_mul(bsdf_lanes_eval(&density, b, dir), radiance);
#if ENV_MAP
    if (k == settings->directional_count) {
        const lanes_float mis = b->alone ? (lanes_float)(1.0f) : lanes_mis_weight(drawn, density);
        value = lanes3_scale(value, drawn > 0.0f ? mis / drawn : (lanes_float)(0.0f));
    }
#endif
    const lanes_int needed = (lanes3_dot(b->normal, dir) > 0.0f) &
                             (lanes3_dot(b->geometric, dir) > 0.0f) & (lanes3_max(value) > 0.0f) &
                             lanes_mask(bits);
    shadow_lanes_set(out, dir, (lanes_float)(FLT_MAX), value, needed);
    return lanes_bits(needed);
}

#endif

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void directional(
    TRACED_PARAMETERS, __global const uint *restrict queue, __global struct ray *restrict rays,
    __global const struct shade *restrict shades, __global struct path *restrict paths,
    __global struct counters *counters, DIRECTIONAL_PARAMETERS, SCATTER_PARAMETERS)
{
    TRACED_SCENE(scene);
    const uint ray_count = DIRECTIONAL_COUNT(settings);
    const uint count = counters[bounce].active;
    uint traced = 0; // shadow rays of this work item
#if SHADE_LANES
    struct scatter_run going;
    going.count = 0;
    SHADOW_LANES_LOOP(i, &counters[bounce].directional_head, count)
    {
        struct shadow_lanes_hits hits;
        if (!shadow_lanes_load(&hits, queue, i, count, rays, paths, shades))
            continue;
        struct lanes3 sum = {0.0f, 0.0f, 0.0f}; // over the shadow rays
        for (uint k = 0; k < ray_count; k++) {
            struct shadow_lanes shadows;
            uint open = directional_draw_lanes(DIRECTIONAL_ARGUMENTS, &shadows, k, hits.slots,
                                               hits.together, &hits.b);
            for (uint rest = hits.others; rest != 0; rest &= rest - 1) {
                const uint slot = hits.slots[bits_lowest(rest)];
                const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
                const struct shadow shadow = directional_draw(DIRECTIONAL_ARGUMENTS, k, slot, &b,
                                                              path_is_alone(&paths[slot]));
                open |= shadow_lanes_set_one(&shadows, bits_lowest(rest), &shadow);
            }
            traced += popcount(open);
            sum = lanes3_add(sum,
                             shadow_lanes_trace(&shadows, nodes, &scene, hits.slots, open, rays));
        }
        shadow_lanes_add(&hits, sum, paths);
        if (scatters != 0)
            scatter_eight(&going, settings, batch, bounce, hits.slots, hits.together, hits.others,
                          &hits.b, shades, rays, paths, points, places, counters, queue_out);
    }
    scatter_run_end(&going, counters, bounce, queue_out);
#else
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].directional_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].directional_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        if (!(as_uint(paths[slot].throughput_bits.w) & PATH_SHADED))
            continue;
        const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
        float3 sum = (float3)(0.0f); // over the shadow rays
        for (uint k = 0; k < ray_count; k++) {
            const struct shadow shadow =
                directional_draw(DIRECTIONAL_ARGUMENTS, k, slot, &b, path_is_alone(&paths[slot]));
            if (shadow_is_needed(&shadow)) {
                traced++;
                sum += shadow_trace(nodes, &scene, rays[slot].org.xyz, &shadow);
            }
        }
        paths[slot].radiance_normal.xyz += paths[slot].throughput_bits.xyz * sum;
        if (scatters != 0)
            scatter_one(settings, batch, bounce, slot, shades, rays, paths, points, places,
                        counters, queue_out);
    }
#endif
    if (traced != 0)
        atomic_add(&counters[bounce].directional_rays, traced);
}
