// Drawing from the light BVH, and what lights really send.

#include "lib/light.h"
#include "lib/light_bvh.h"
#include "test.h"

// The probability of every light at every point.
TEST_KERNEL light_bvh_pmfs(__global const struct light_bvh_node *nodes,
                           __global const uint *parents, __global const uint *leaves,
                           __global const float4 *points, __global const float4 *normals,
                           const uint light_count, __global float *pmfs, const uint count)
{
    const uint i = get_global_id(0);
    if (i < count)
        pmfs[i] = light_bvh_pmf(nodes, parents, leaves, points[i / light_count].xyz,
                                normals[i / light_count].xyz, i % light_count);
}

// `draws` lights at every point, and with which probability.
TEST_KERNEL light_bvh_draws(__global const struct light_bvh_node *nodes,
                            __global const float4 *points, __global const float4 *normals,
                            const uint draws, __global uint *lights, __global float *pmfs,
                            const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    float pmf;
    lights[i] = light_bvh_draw(&pmf, nodes, points[i / draws].xyz, normals[i / draws].xyz,
                               rng_bits(1, i, 2, 3).x);
    pmfs[i] = pmf;
}

// The most, of some samples, that every light sends to every point, times the cosine there.
TEST_KERNEL light_bvh_contributions(__global const struct light *lights,
                                    __global const struct light_shape *shapes,
                                    __global const struct triangle *triangles,
                                    __global const struct vertex *vertices,
                                    __global const struct material *materials,
                                    __global const float4 *points, __global const float4 *normals,
                                    const uint light_count, __global float *most, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    struct surface surface;
    surface.vertices = vertices;
    surface.triangles = triangles;
    surface.materials = materials;
    float sum = 0.0f;
    for (uint k = 0; k < 8; k++) {
        const uint4 bits = rng_bits(7, i, k, 3);
        const struct light_sample sampled =
            light_sample(lights, shapes, i % light_count, &surface, points[i / light_count].xyz,
                         rng_unit(bits.x), rng_unit(bits.y));
        const float cosine = dot(sampled.dir, normals[i / light_count].xyz);
        if (cosine > 0.0f)
            sum = max2(sum, cosine * max3(sampled.radiance));
    }
    most[i] = sum;
}
