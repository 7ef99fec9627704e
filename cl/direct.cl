// Stage 5, direct: light from the lights of the tree at every shaded hit, by shadow rays.
//
//   in    rays, paths, shades, queue of this bounce, lights and their tree, BVH
//   out   paths[slot].radiance; if it scatters, what scatter does
//   next  directional or scatter, or if it scatters, trace
//
// Variants: those of trace; LIGHT_SAMPLER (lib/light_sampler.h). With SHADE_LANES
// (lib/shade_lanes.h) shadow rays of eight hits are drawn side by side, but for BSDFs that
// lib/bsdf_lanes.h leaves out. If no other light is to come, the stage does the work of scatter,
// too: what that reads is at hand.

#include "lib/light_group.h" // first: it sets WG_TRACE

#include "lib/direct_hit.h"
#include "lib/queue.h"
#include "lib/scatter.h"
#if SHADE_LANES
#include "lib/direct_lanes.h"
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
        const struct lanes_place place = lanes_place(batch, places, lanes_load(hits.slots), bounce);
        struct lanes3 sum = {0.0f, 0.0f, 0.0f}; // over the shadow rays
        for (uint round = 0; round < round_count; round++) {
            // Choose lights.
            const struct lanes_numbers chosen =
                direct_lanes_numbers(settings, points, place, round);
            struct direct_lanes d;
            uint left = hits.together | hits.others; // that have a light left
            direct_lanes_begin(&d, settings, light_nodes, &hits.b, left, round, chosen.x);
            for (;;) {
                left = direct_lanes_next(&d, settings, light_nodes, left);
                if (left == 0)
                    break;

                // Draw points on them, and weigh what comes from there.
                const struct lanes_numbers numbers =
                    direct_lanes_place_numbers(settings, points, place, round, chosen, &d);
                const lanes_float u0 = lanes_unit(numbers.y);
                const lanes_float u1 = lanes_unit(numbers.z);
                const struct direct_lanes_shadows drawn = direct_lanes_weigh(
                    &d, lights, shapes, &scene.surface, left & hits.together, &hits.b, u0, u1);
                struct shadow_lanes shadows;
                shadow_lanes_set(&shadows, drawn.dir, drawn.reach, drawn.value, drawn.needed);
                uint open = lanes_bits(drawn.needed);
                float s[LANES], t[LANES], expected[LANES];
                lanes_store(u0, s);
                lanes_store(u1, t);
                lanes_store(d.expected, expected);
                for (uint rest = left & hits.others; rest != 0; rest &= rest - 1) {
                    const uint k = bits_lowest(rest);
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
            scatter_eight(&going, settings, batch, bounce, hits.slots, hits.together, hits.others,
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
