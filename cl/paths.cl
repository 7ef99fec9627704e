// Stages 2 to 7 in one, paths: whole paths of scenes of few triangles that are all Lambert, on
// CPUs.
//
//   in    rays, paths; triangles of the 8-wide BVH, lights and their tree
//   out   paths[slot].radiance_normal; counters
//   next  film
//
// There hits are found and lit faster than stages hand them on to each other through memory: a work
// item takes a run of paths from their first ray to their end, eight side by side. Two cores render
// the Cornell box 1.4 times as fast as with the stages apart. What is computed is what trace_few,
// material and direct compute, with colours and normals rounded as they write them, so that images
// agree.
//
// Variants: LIGHT_SAMPLER, LIGHT_BVH_FLAT, EMITTERS, UNTEXTURED.

#if DEVICE_CPU && BVH_WIDE && !ALPHA

#include "lib/direct_lanes.h"
#include "lib/material_lanes.h"
#include "lib/scatter.h"
#include "lib/traverse_few.h"

// What a work item's paths run through.
struct paths_scene {
    const struct few *few;
    struct surface surface;
    __constant struct settings *settings;
    __global const uint *triangle_emitters;
    __global const struct light *lights;
    __global const struct light_shape *shapes;
    __global const float4 *light_nodes;
    __global const uint *light_parents, *light_leaves;
    __global const uint4 *points;
    __global const uint *places;
};

// A run of paths, those that are alive, at one bounce.
struct paths_run {
    uint slots[SHADE_RUN + LANES];  // the last eight are filled up with some of them
    float4 hits[SHADE_RUN + LANES]; // struct hit
    uint count;
    uint shadow_rays;
};

// The hits as the stages after material read them.
static inline struct lambert_lanes paths_lambert(const struct material_lanes_shaded *m)
{
    const uint8 xy = as_uint8(lanes_pack_shares(m->diffuse.x, m->diffuse.y));
    const uint8 zw = as_uint8(lanes_pack_shares(m->diffuse.z, m->dielectric_f0));
    struct lambert_lanes out;
    out.org = m->org;
    out.normal = lanes_oct_unpack(lanes_oct_pack(m->normal));
    out.geometric = lanes_oct_unpack(lanes_oct_pack(m->geometric));
    out.diffuse = lanes3_xyz(lanes_unpack_shares(xy, zw));
    out.throughput = m->throughput;
    out.alone = (m->bits & PATH_NO_BOUNCE) != 0u;
    return out;
}

// Finds the nearest hits of a run. Paths that hit nothing leave it.
//
//   alike  constant: neighbours' rays run alike
static inline void paths_trace(struct paths_run *run, const struct few *few,
                               __global const struct ray *rays, const bool alike)
{
    const uint count = run->count;
    uint met_count = 0;
    for (uint i = 0; i < count; i += LANES) {
        uint slots[LANES];
        vstore8(vload8(0, run->slots + i), 0, slots);
        const struct lanes4 org = LANES_OF(rays, slots, .org);
        const struct lanes4 dir = LANES_OF(rays, slots, .dir);
        struct few_hits found = few_hits_begin((float8)(FLT_MAX));
        traverse_few(&found, few, lanes3_xyz(org), lanes3_xyz(dir), (float8)(0.0f), alike);
        uint met = lanes_bits(found.place != HIT_NONE);
        if (count - i < LANES)
            met &= (1u << (count - i)) - 1u;
        float4 rows[LANES];
        const struct lanes_rows hits = lanes_turn_back(few_name(&found, few));
        rows[0] = hits.r04.lo;
        rows[1] = hits.r15.lo;
        rows[2] = hits.r26.lo;
        rows[3] = hits.r37.lo;
        rows[4] = hits.r04.hi;
        rows[5] = hits.r15.hi;
        rows[6] = hits.r26.hi;
        rows[7] = hits.r37.hi;
        for (uint k = 0; k < LANES; k++) { // without branches: what does not count is overwritten
            run->slots[met_count] = slots[k];
            run->hits[met_count] = rows[k];
            met_count += (met >> k) & 1u;
        }
    }
    run->count = met_count;
    for (uint k = 0; k < LANES && met_count != 0; k++) {
        run->slots[met_count + k] = run->slots[met_count - 1];
        run->hits[met_count + k] = run->hits[met_count - 1];
    }
}

// The light that comes to eight hits by shadow rays.
static inline struct lanes3 paths_light(struct paths_run *run, const struct paths_scene *s,
                                        const uint bounce, const struct lanes_place place,
                                        const struct lambert_lanes *b, const uint used)
{
    const float8 zero = (float8)(0.0f);
    const struct lanes3 none = {zero, zero, zero};
    struct lanes3 sum = none;
    for (uint round = 0; round < light_round_count(s->settings); round++) {
        const struct lanes_numbers chosen =
            direct_lanes_numbers(s->settings, s->points, place, bounce, round);
        struct direct_lanes d;
        uint left = used; // that have a light left
        direct_lanes_begin(&d, s->settings, s->light_nodes, b, left, round, chosen.x);
        while ((left = direct_lanes_next(&d, s->settings, s->light_nodes, left)) != 0) {
            const struct lanes_numbers numbers = direct_lanes_place_numbers(
                s->settings, s->points, place, bounce, round, chosen, &d);
            const struct direct_lanes_shadows shadows =
                direct_lanes_weigh(&d, s->lights, s->shapes, &s->surface, left, b,
                                   lanes_unit(numbers.y), lanes_unit(numbers.z));
            const int8 stopped = traverse_few_any(s->few, b->org, shadows.dir, shadows.reach);
            run->shadow_rays += popcount(lanes_bits(shadows.needed));
            sum = lanes3_add(sum, lanes3_select(shadows.needed & ~stopped, shadows.value, none));
        }
    }
    return sum;
}

// Shades the eight hits from place `first` of the run on, lights them and sends them on. Returns
// bits of those that go on.
static inline uint paths_shade(struct paths_run *run, const uint first, const struct paths_scene *s,
                               const struct batch batch, const uint bounce,
                               __global struct ray *rays, __global struct path *paths)
{
    const uint rest = run->count - first;
    const uint used = rest < LANES ? (1u << rest) - 1u : 0xffu;
    __private const float4 *hits = run->hits + first;
    struct material_lanes_hits h;
    vstore8(vload8(0, run->slots + first), 0, h.slots);
    const uint *slots = h.slots;
    material_lanes_see(
        &h, used,
        lanes_turn(hits[0], hits[1], hits[2], hits[3], hits[4], hits[5], hits[6], hits[7]),
        &s->surface);
    struct material_lanes_shaded m;
    material_lanes_shade(&m, s->settings, bounce, &h, &s->surface, s->triangle_emitters, s->lights,
                         s->shapes, s->light_nodes, s->light_parents, s->light_leaves, rays,
                         LANES_OF(rays, slots, .dir), LANES_OF(paths, slots, .throughput_bits),
                         LANES_OF(paths, slots, .radiance_normal));
    const struct lambert_lanes b = paths_lambert(&m);

    const struct lanes_place place = lanes_place(batch, s->places, vload8(0, slots));
    const struct lanes3 sum = paths_light(run, s, bounce, place, &b, used);
    const struct lanes3 radiance = lanes3_add(m.radiance, lanes3_mul(m.throughput, sum));
    LANES_STORE(paths, slots, .radiance_normal, used,
                lanes4_make(radiance, as_float8(lanes_oct_pack(m.normal))));
    if (bounce + 1 == s->settings->depth)
        return 0;
    LANES_STORE(rays, slots, .org, used, lanes4_make(m.org, (float8)(0.0f)));
    return scatter_lanes(s->settings, bounce, place, slots, used, &b, rays, paths, s->points);
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void paths(
    __global const float4 *restrict woop, __global const uint *restrict refs,
    __global const struct vertex *vertices, __global const uint2 *colors,
    __global const struct triangle *triangles, __global const struct material *materials,
    __global const uint *texels, const uint block_count, __constant struct settings *settings,
    const struct batch batch, __global const uint *restrict triangle_emitters,
    __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict light_parents, __global const uint *restrict light_leaves,
    __global struct ray *restrict rays, __global struct path *restrict paths,
    __global struct counters *counters, __global const uint4 *restrict points,
    __global const uint *restrict places)
{
    struct few few;
    few_begin(&few, woop, refs, block_count);
    const struct paths_scene scene = {
        &few,         {vertices, colors, triangles, materials, texels},
        settings,     triangle_emitters,
        lights,       shapes,
        light_nodes,  light_parents,
        light_leaves, points,
        places};
    for (uint first = get_global_id(0) * SHADE_RUN; first < batch.count;
         first += get_global_size(0) * SHADE_RUN) {
        struct paths_run run;
        run.count = min(SHADE_RUN, batch.count - first);
        for (uint i = 0; i < run.count; i++)
            run.slots[i] = first + i;
        for (uint bounce = 0; bounce < settings->depth && run.count != 0; bounce++) {
            for (uint k = 0; k < LANES; k++)
                run.slots[run.count + k] = run.slots[run.count - 1];
            if (bounce == 0)
                paths_trace(&run, &few, rays, true);
            else
                paths_trace(&run, &few, rays, false);
            uint going_count = 0;
            run.shadow_rays = 0;
            for (uint i = 0; i < run.count; i += LANES) {
                uint going = paths_shade(&run, i, &scene, batch, bounce, rays, paths);
                for (uint k = 0; k < LANES; k++) {
                    run.slots[going_count] = run.slots[i + k];
                    going_count += (going >> k) & 1u;
                }
            }
            if (run.shadow_rays != 0)
                atomic_add(&counters[bounce].shadow_rays, run.shadow_rays);
            if (going_count != 0)
                atomic_add(&counters[bounce + 1].active, going_count);
            run.count = going_count;
        }
    }
}

#endif
