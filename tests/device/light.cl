// lib/light.h: drawing lights, and points on them.

#include "lib/light.h"
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

// Samples one light from points[i] by numbers[i].
TEST_KERNEL light_samples(__global const struct light *lights,
                          __global const struct light_shape *shapes, const uint light,
                          __global const struct vertex *vertices,
                          __global const struct triangle *triangles,
                          __global const struct material *materials, __global const uint *texels,
                          __global const float4 *points, __global const float4 *numbers,
                          const uint count, __global float4 *dir_distance,
                          __global float4 *radiance_density)
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
    const struct light_sample sampled =
        light_sample(lights, shapes, light, &surface, points[i].xyz, numbers[i].x, numbers[i].y);
    dir_distance[i] = (float4)(sampled.dir, sampled.distance);
    radiance_density[i] = (float4)(sampled.radiance, sampled.density);
}
