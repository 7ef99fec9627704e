// lib/light.h: drawing lights, and points on them.

#include "lib/light.h"
#include "lib/light_lanes.h"
#include "test.h"

TEST_KERNEL light_draws(__global const struct light_node *nodes, const float4 p,
                        __global const uint *bits, const uint count, __global uint *lights,
                        __global float *pmfs)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    float pmf = 0.0f;
    lights[i] = light_tree_draw(&pmf, nodes, p.xyz, bits[i]);
    pmfs[i] = pmf;
}

// Probability of every light at p.
TEST_KERNEL light_pmfs(__global const struct light_node *nodes, __global const uint *parents,
                       __global const uint *leaves, const float4 p, const uint light_count,
                       __global float *pmfs)
{
    const uint i = get_global_id(0);
    if (i < light_count)
        pmfs[i] = light_tree_pmf(nodes, parents, leaves, p.xyz, i);
}

// Samples one light from points[i], on a surface with this normal, by numbers[i].
TEST_KERNEL light_samples(__global const struct light *lights,
                          __global const struct light_shape *shapes, const uint light,
                          __global const struct vertex *vertices,
                          __global const struct triangle *triangles,
                          __global const struct material *materials, __global const uint *texels,
                          __global const float4 *points, const float4 normal,
                          __global const float4 *numbers, const uint count,
                          __global float4 *dir_distance, __global float4 *radiance_density)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    struct surface surface;
    surface.vertices = vertices;
    surface.colors = 0;
    surface.triangles = triangles;
    surface.materials = materials;
    surface.texels = texels;
    const struct light_sample sampled = light_sample(lights, shapes, light, &surface, points[i].xyz,
                                                     normal.xyz, numbers[i].x, numbers[i].y);
    dir_distance[i] = (float4)(sampled.dir, sampled.distance);
    radiance_density[i] = (float4)(sampled.radiance, sampled.density);
}

// As light_samples, LANES points an item; count is a multiple.
TEST_KERNEL light_samples_together(__global const struct light *lights,
                                   __global const struct light_shape *shapes, const uint light,
                                   __global const struct vertex *vertices,
                                   __global const struct triangle *triangles,
                                   __global const struct material *materials,
                                   __global const uint *texels, __global const float4 *points,
                                   const float4 normal, __global const float4 *numbers,
                                   const uint count, __global float4 *dir_distance,
                                   __global float4 *radiance_density)
{
    const uint first = get_global_id(0) * LANES;
    if (first >= count)
        return;
    const struct surface surface = {vertices, 0, triangles, materials, texels};
    uint slots[LANES], index[LANES];
    lanes_store(first + lanes_as_uint(LANES_ORDER), slots);
    lanes_store((lanes_uint)(light), index);
    const struct lanes4 p = LANES_OF(points, slots, );
    const struct lanes4 u = LANES_OF(numbers, slots, );
    const struct lanes3 up = {(lanes_float)(normal.x), (lanes_float)(normal.y),
                              (lanes_float)(normal.z)};
    const struct light_lanes sampled =
        light_lanes_sample(lights, shapes, index, LANES_ALL, &surface, lanes3_xyz(p), up, u.x, u.y);
    LANES_STORE(dir_distance, slots, , LANES_ALL, lanes4_make(sampled.dir, sampled.distance));
    LANES_STORE(radiance_density, slots, , LANES_ALL,
                lanes4_make(sampled.radiance, sampled.density));
}

// The density of what light_samples draws, asked of rays from points[i] that hit the light.
//
//   rays  xyz unit direction; w distance
TEST_KERNEL light_hit_densities(__global const struct light *lights,
                                __global const struct light_shape *shapes,
                                __global const float4 *points, __global const float4 *rays,
                                const uint count, __global float4 *densities)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    const float3 normal = normalize(cross(shapes[0].edge_u.xyz, shapes[0].edge_v.xyz));
    const float cosine = fabs(dot(normal, rays[i].xyz));
    densities[i] = (float4)(light_hit_density(lights, shapes, 0, points[i].xyz, rays[i].w, cosine),
                            cosine, 0.0f, 0.0f);
}
