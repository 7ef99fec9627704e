/**
 * @file
 * What is made of hits side by side, on CPUs: for lib/material_lanes.h, lib/few_surface.h and
 * cl/paths.cl.
 */
#ifndef LIB_HIT_LANES_H
#define LIB_HIT_LANES_H

#include "lib/lanes.h"
#include "lib/light_sampler.h"
#include "lib/surface.h"

// The weights of what surfaces emit towards paths that met them, against light samples.
//
//   triangle  that rays have met
//   bits      lanes where light samples may find the same; of others the weights are 1
//   org       where the rays come from
//   before    shading normals there
//   density   with which the rays were drawn, 1/sr
//   t         distances
//   cosine    between surfaces and rays
static inline lanes_float hit_lanes_weights(
    __constant struct settings *settings, __global const uint *triangle_emitters,
    __global const struct light *lights, __global const struct light_shape *shapes,
    __global const float4 *light_nodes, __global const uint *light_parents,
    __global const uint *light_leaves, const uint *triangle, const uint bits,
    const struct lanes3 org, const struct lanes3 before, const lanes_float density,
    const lanes_float t, const lanes_float cosine)
{
    float cosines[LANES], start[3][LANES], normal[3][LANES], distances[LANES], densities[LANES];
    lanes_float weight = (lanes_float)(1.0f);
    lanes_store(fabs(cosine), cosines);
    lanes_store(org.x, start[0]);
    lanes_store(org.y, start[1]);
    lanes_store(org.z, start[2]);
    lanes_store(before.x, normal[0]);
    lanes_store(before.y, normal[1]);
    lanes_store(before.z, normal[2]);
    lanes_store(t, distances);
    lanes_store(density, densities);
    for (uint rest = bits; rest != 0; rest &= rest - 1) {
        const uint k = bits_lowest(rest);
        const uint emitter = triangle_emitters[triangle[k]];
        if (emitter == EMITTER_NONE)
            continue;
        const float3 from = (float3)(start[0][k], start[1][k], start[2][k]);
        const float drawn =
            light_hit_density(lights, shapes, emitter, from, distances[k], cosines[k]);
        const float count =
            light_expected_count(settings, light_nodes, light_parents, light_leaves, from,
                                 (float3)(normal[0][k], normal[1][k], normal[2][k]), emitter);
        weight = lanes_put(weight, k, mis_weight(densities[k], count * drawn));
    }
    return weight;
}

// Shading normals on the sides of their triangles that the geometric normals are on.
//
//   n0, n1, n2  of the corners, oct_pack()
//   u, v        weights of the second and the third
static inline struct lanes3 hit_lanes_normal(const lanes_uint n0, const lanes_uint n1,
                                             const lanes_uint n2, const lanes_float u,
                                             const lanes_float v, const struct lanes3 geometric)
{
    const struct lanes3 blended = lanes3_muladd(
        lanes_oct_unpack(n0), 1.0f - u - v,
        lanes3_muladd(lanes_oct_unpack(n1), u, lanes3_scale(lanes_oct_unpack(n2), v)));
    const struct lanes3 normal =
        lanes3_select(lanes3_dot(blended, blended) > 0.0f, lanes3_normalize(blended), geometric);
    const lanes_int away = lanes3_dot(normal, geometric) < 0.0f;
    return lanes3_scale(normal, away ? (lanes_float)(-1.0f) : (lanes_float)(1.0f));
}

// Where rays leave surfaces: surface_offset().
static inline struct lanes3 hit_lanes_offset(const struct lanes3 p, const struct lanes3 normal)
{
    const lanes_float largest = lanes_max(lanes_max(fabs(p.x), fabs(p.y)), fabs(p.z));
    return lanes3_muladd(normal, largest * SURFACE_OFFSET + SURFACE_OFFSET_LEAST, p);
}

#endif
