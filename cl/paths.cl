// Stages 1 to 7 in one, paths: whole paths of scenes of few triangles that are all Lambert, on
// CPUs.
//
//   in    camera, batch, points, places; triangles of the 8-wide BVH, lights and their tree
//   out   paths[slot].radiance_normal.xyz; counters
//   next  film
//
// There hits are found and lit faster than stages hand them on to each other through memory. A work
// item takes a run of paths, LANES side by side; where one ends, the next of the run begins in its
// lane, so that no lane waits for others, whichever bounces they are at. What is computed is what
// raygen, trace_few, material and direct compute, with colours and normals rounded as they write
// them, so that images agree.
//
// Variants: LIGHT_SAMPLER, LIGHT_BVH_FLAT, EMITTERS, UNTEXTURED.

#if DEVICE_CPU && BVH_WIDE && !ALPHA

#include "lib/lanes_most.h"

#include "lib/direct_lanes.h"
#include "lib/few_surface.h"
#include "lib/raygen_lanes.h"
#include "lib/scatter.h"

// What a work item's paths run through.
struct paths_scene {
    const struct few *few;
    const struct few_surface *few_surface;
    struct surface surface;
    __constant struct settings *settings;
    __constant struct camera *camera;
    struct batch batch;
    __global const uint *places;
    __global const uint *triangle_emitters;
    __global const struct light *lights;
    __global const struct light_shape *shapes;
    __global const float4 *light_nodes;
    __global const uint *light_parents, *light_leaves;
    __global const uint4 *points;
};

// Paths that wait for lanes.
struct paths_next {
    uint slot, end; // the next to begin, and past the last of the run
    float org[3][LANES], dir[3][LANES];
    uint pixel[LANES], sample[LANES];
};

// Paths side by side, each at a bounce of its own: its ray, and where that comes from. Lanes that
// are idle take part: they keep the place of a path that has ended.
struct paths_lanes {
    uint slots[LANES];
    struct lanes_place place;
    struct lanes3 org, dir;
    struct lanes3 normal; // shading normal that the ray left
    lanes_float density;  // with which it was drawn, 1/sr
    struct lanes3 throughput, radiance;
};

// Prepares the paths from next->slot on.
static inline void paths_prepare(struct paths_next *next, const struct paths_scene *s)
{
    const lanes_uint slot = next->slot + lanes_as_uint(LANES_ORDER);
    const struct lanes_place place = lanes_place(s->batch, s->places, min(slot, next->end - 1), 0);
    struct lanes3 org, dir;
    raygen_lanes_rays(&org, &dir, s->settings, s->camera, place, s->points);
    lanes_store(org.x, next->org[0]);
    lanes_store(org.y, next->org[1]);
    lanes_store(org.z, next->org[2]);
    lanes_store(dir.x, next->dir[0]);
    lanes_store(dir.y, next->dir[1]);
    lanes_store(dir.z, next->dir[2]);
    lanes_store(place.pixel, next->pixel);
    lanes_store(place.sample, next->sample);
}

// Begins paths in those lanes that are idle, while there are any. Returns bits of the lanes.
static inline uint paths_begin(struct paths_lanes *p, struct paths_next *next, const uint idle,
                               const struct paths_scene *s)
{
    uint begun = 0;
    for (uint rest = idle; rest != 0 && next->slot != next->end; rest &= rest - 1) {
        const uint k = bits_lowest(rest);
        const uint i = next->slot % LANES;
        if (i == 0)
            paths_prepare(next, s);
        p->org = lanes3_put(p->org, k, (float3)(next->org[0][i], next->org[1][i], next->org[2][i]));
        p->dir = lanes3_put(p->dir, k, (float3)(next->dir[0][i], next->dir[1][i], next->dir[2][i]));
        p->place.pixel = lanes_put_word(p->place.pixel, k, next->pixel[i]);
        p->place.sample = lanes_put_word(p->place.sample, k, next->sample[i]);
        p->slots[k] = next->slot++;
        begun |= 1u << k;
    }
    const lanes_int fresh = lanes_mask(begun);
    const struct lanes3 none = {(lanes_float)(0.0f), (lanes_float)(0.0f), (lanes_float)(0.0f)};
    const struct lanes3 all = {(lanes_float)(1.0f), (lanes_float)(1.0f), (lanes_float)(1.0f)};
    p->place.bounce = fresh ? (lanes_uint)(0u) : p->place.bounce;
    p->throughput = lanes3_select(fresh, all, p->throughput);
    p->radiance = lanes3_select(fresh, none, p->radiance);
    return begun;
}

// Hands over what the paths of those lanes that have a bit have collected.
static inline void paths_end(const struct paths_lanes *p, const uint bits,
                             __global struct path *paths)
{
    float radiance[3][LANES];
    lanes_store(p->radiance.x, radiance[0]);
    lanes_store(p->radiance.y, radiance[1]);
    lanes_store(p->radiance.z, radiance[2]);
    for (uint rest = bits; rest != 0; rest &= rest - 1) {
        const uint k = bits_lowest(rest);
        paths[p->slots[k]].radiance_normal =
            (float4)(radiance[0][k], radiance[1][k], radiance[2][k], 0.0f);
    }
}

// Adds what is emitted towards the paths.
//
//   bits    lanes whose triangles shine on some side
//   side    that they have hit, in struct few_surface
//   cosine  between triangles and rays
static inline void paths_add_emission(struct paths_lanes *p, const struct paths_scene *s,
                                      const uint bits, const uint *side, const lanes_float cosine,
                                      const struct few_hits *found)
{
    const struct lanes4 row = LANES_OF(s->few_surface->sides, side, .emission);
    struct lanes3 emission = lanes3_xyz(row);
    const uint shining = bits & lanes_bits(lanes3_max(emission) > 0.0f);
    if (shining == 0)
        return;
    struct material_lanes_hits h;
    material_lanes_see(&h, shining, few_name(found, s->few), &s->surface);
    emission = lanes3_mul(
        emission, lanes3_xyz(material_lanes_fetch(&s->surface, &h, shining, TEXTURE_EMISSIVE)));
    const uint met_by_light = shining & lanes_bits(p->place.bounce != 0u);
    const lanes_float weight = hit_lanes_weights(
        s->settings, s->triangle_emitters, s->lights, s->shapes, s->light_nodes, s->light_parents,
        s->light_leaves, h.triangle, met_by_light, p->org, p->normal, p->density, found->t, cosine);
    const lanes_float counts = lanes_mask(shining) ? weight : (lanes_float)(0.0f);
    p->radiance =
        lanes3_add(p->radiance, lanes3_mul(lanes3_scale(p->throughput, counts), emission));
}

// Shades what the rays of the lanes that have a bit have hit.
static inline struct bsdf_lanes paths_shade(struct paths_lanes *p, const struct paths_scene *s,
                                            const uint bits, const struct few_hits *found)
{
    // Find the points, and the sides that are seen.
    const struct few_surface *table = s->few_surface;
    uint place[LANES], side[LANES];
    few_index(place, found);
    const struct lanes4 corner = LANES_OF(table->corners, place, .corner_red);
    const struct lanes4 edge1 = LANES_OF(table->corners, place, .edge1_green);
    const struct lanes4 edge2 = LANES_OF(table->corners, place, .edge2_blue);
    const struct lanes4 geometric_flags = LANES_OF(table->corners, place, .geometric_flags);
    const struct lanes3 at =
        lanes3_muladd(lanes3_xyz(edge1), found->u,
                      lanes3_muladd(lanes3_xyz(edge2), found->v, lanes3_xyz(corner)));
    const struct lanes3 upward = lanes3_xyz(geometric_flags);
    const lanes_uint flags = lanes_as_uint(geometric_flags.w);
    const lanes_float cosine = lanes3_dot(upward, p->dir);
    const lanes_int behind = !(cosine < 0.0f);
    const lanes_float sign = behind ? (lanes_float)(-1.0f) : (lanes_float)(1.0f);
    lanes_store(2u * lanes_load(place) - lanes_as_uint(behind), side);

    // Add what they emit, but for irradiance that which shines back.
    const bool measures = s->settings->quantity == QUANTITY_IRRADIANCE;
    const lanes_int measured = measures ? p->place.bounce == 0u : (lanes_int)(0);
    const uint shining = bits & lanes_bits(((flags & FEW_SHINES) != 0u) & ~measured);
    if (shining != 0)
        paths_add_emission(p, s, shining, side, cosine, found);

    // Turn the normals to the viewer; a shading normal that looks away is of no use.
    struct bsdf_lanes b;
    b.glossy = 0; // all are Lambert
    const struct lanes4 geometric = LANES_OF(table->sides, side, .geometric);
    const struct lanes4 normal = LANES_OF(table->sides, side, .normal);
    b.geometric = lanes3_xyz(geometric);
    b.normal = lanes3_xyz(normal);
    if (lanes_bits((flags & FEW_SMOOTH) != 0u) != 0) {
        const struct lanes4 n = LANES_OF(table->normals, place, );
        b.normal = few_round_normal(
            lanes3_scale(hit_lanes_normal(lanes_as_uint(n.x), lanes_as_uint(n.y),
                                          lanes_as_uint(n.z), found->u, found->v, upward),
                         sign));
    }
    b.normal = lanes3_select(lanes3_dot(b.normal, p->dir) < -1e-4f, b.normal, b.geometric);
    b.org = hit_lanes_offset(at, lanes3_scale(upward, sign));

    // Find their colours.
    b.diffuse = lanes3_make(corner.w, edge1.w, edge2.w);
    if ((bits & lanes_bits((flags & FEW_TEXTURED) != 0u)) != 0) {
        struct material_lanes_hits h;
        material_lanes_see(&h, bits, few_name(found, s->few), &s->surface);
        const struct lanes4 base = LANES_OF(s->surface.materials, h.material, .base);
        b.diffuse = few_round_color(
            lanes3_mul(lanes3_xyz(base),
                       lanes3_xyz(texture_lanes_fetch(&h.base, h.textured, s->surface.texels))));
    }
    b.throughput = p->throughput;
    if (measures) { // f = 1 / pi, so that pi times what leaves is the irradiance
        const struct lanes3 all = {(lanes_float)(1.0f), (lanes_float)(1.0f), (lanes_float)(1.0f)};
        b.diffuse = lanes3_select(measured, all, b.diffuse);
        b.throughput =
            lanes3_scale(b.throughput, measured ? (lanes_float)(PI) : (lanes_float)(1.0f));
    }
    b.alone = p->place.bounce + 1u == s->settings->depth;
    return b;
}

// The light that comes by shadow rays to those hits that have a bit.
static inline struct lanes3 paths_light(const struct paths_scene *s, const struct lanes_place place,
                                        const struct bsdf_lanes *b, const uint bits,
                                        uint *shadow_rays)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const struct lanes3 none = {zero, zero, zero};
    struct lanes3 sum = none;
    for (uint round = 0; round < light_round_count(s->settings); round++) {
        const struct lanes_numbers chosen =
            direct_lanes_numbers(s->settings, s->points, place, round);
        struct direct_lanes d;
        uint left = bits; // that have a light left
        direct_lanes_begin(&d, s->settings, s->light_nodes, b, left, round, chosen.x);
        while ((left = direct_lanes_next(&d, s->settings, s->light_nodes, left)) != 0) {
            const struct lanes_numbers numbers =
                direct_lanes_place_numbers(s->settings, s->points, place, round, chosen, &d);
            const struct direct_lanes_shadows shadows =
                direct_lanes_weigh(&d, s->lights, s->shapes, &s->surface, left, b,
                                   lanes_unit(numbers.y), lanes_unit(numbers.z));
            const lanes_int stopped = traverse_few_any(s->few, b->org, shadows.dir, shadows.reach);
            *shadow_rays += popcount(lanes_bits(shadows.needed));
            sum = lanes3_add(sum, lanes3_select(shadows.needed & ~stopped, shadows.value, none));
        }
    }
    return sum;
}

// Takes the paths of those lanes that have a bit through a bounce. Returns bits of those that go
// on.
static inline uint paths_bounce(struct paths_lanes *p, const struct paths_scene *s,
                                const uint alive, uint *shadow_rays)
{
    struct few_hits found = few_hits_begin((lanes_float)(FLT_MAX));
    const lanes_float zero = (lanes_float)(0.0f);
    if (lanes_bits(p->place.bounce == 0u) == LANES_ALL)
        traverse_few(&found, s->few, p->org, p->dir, zero, true);
    else
        traverse_few(&found, s->few, p->org, p->dir, zero, false);
    const uint met = alive & lanes_bits(found.place != HIT_NONE);
    if (met == 0)
        return 0;
    const struct lanes_numbers numbers = scatter_lanes_numbers(s->settings, p->place, s->points);
    const struct bsdf_lanes b = paths_shade(p, s, met, &found);
    const struct lanes3 sum = paths_light(s, p->place, &b, met, shadow_rays);
    const struct lanes3 lit = lanes3_add(p->radiance, lanes3_mul(b.throughput, sum));
    p->radiance = lanes3_select(lanes_mask(met), lit, p->radiance);
    const uint rest = met & ~lanes_bits(b.alone);
    if (rest == 0)
        return 0;
    const struct scatter_lanes next = scatter_lanes_sample(s->settings, p->place, numbers, &b);
    p->org = b.org;
    p->dir = next.dir;
    p->normal = b.normal;
    p->density = next.density;
    p->throughput = next.throughput;
    const uint going = rest & lanes_bits(next.goes);
    p->place.bounce -= lanes_as_uint(lanes_mask(going)); // of idle lanes it stays in range
    return going;
}

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void paths(
    __global const float4 *restrict woop, __global const uint *restrict refs,
    __global const struct vertex *vertices, __global const uint2 *colors,
    __global const struct triangle *triangles, __global const struct material *materials,
    __global const uint *texels, const uint block_count, __constant struct settings *settings,
    __constant struct camera *camera, const struct batch batch,
    __global const uint *restrict triangle_emitters, __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict light_parents, __global const uint *restrict light_leaves,
    __global struct path *restrict paths, __global struct counters *counters,
    __global const uint4 *restrict points, __global const uint *restrict places)
{
    const uint per_item =
        ((batch.count + get_global_size(0) * LANES - 1) / (get_global_size(0) * LANES)) * LANES;
    struct paths_next next;
    next.slot = get_global_id(0) * per_item;
    next.end = min(next.slot + per_item, batch.count);
    if (next.slot >= next.end)
        return;

    struct few few;
    struct few_surface few_surface;
    const struct surface surface = {vertices, colors, triangles, materials, texels};
    few_begin(&few, woop, refs, block_count);
    few_surface_begin(&few_surface, &few, &surface);
    const struct paths_scene scene = {&few,         &few_surface, surface,     settings,
                                      camera,       batch,        places,      triangle_emitters,
                                      lights,       shapes,       light_nodes, light_parents,
                                      light_leaves, points};
    const lanes_float zero = (lanes_float)(0.0f);
    const struct lanes3 none = {zero, zero, zero};
    struct paths_lanes p = {.org = none,
                            .dir = none,
                            .normal = none,
                            .density = zero,
                            .throughput = none,
                            .radiance = none};
    p.place.pixel = p.place.sample = p.place.bounce = (lanes_uint)(0u);
    uint shadow_rays = 0;
    uint indirect_rays = 0;
    for (uint alive = 0;;) {
        alive |= paths_begin(&p, &next, ~alive & LANES_ALL, &scene);
        if (alive == 0)
            break;
        const uint going = paths_bounce(&p, &scene, alive, &shadow_rays);
        paths_end(&p, alive & ~going, paths);
        indirect_rays += popcount(going);
        alive = going;
    }
    // How many there were of all batches is what is asked, not at which bounces.
    atomic_add(&counters[0].shadow_rays, shadow_rays);
    atomic_add(&counters[1].rays, indirect_rays);
}

#endif
