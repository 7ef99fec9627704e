// Drawing from the light BVH, and what lights really send.

#include "lib/light.h"
#include "lib/light_bvh.h"
#include "test.h"

// The share of every light at every point.
TEST_KERNEL light_bvh_shares(__global const struct light_bvh_node *nodes,
                             __global const uint *parents, __global const uint *leaves,
                             __global const float4 *points, __global const float4 *normals,
                             const uint light_count, __global float *shares, const uint count)
{
    const uint i = get_global_id(0);
    if (i < count)
        shares[i] = light_bvh_share(nodes, parents, leaves, points[i / light_count].xyz,
                                    normals[i / light_count].xyz, i % light_count);
}

// `walks` walks at every point: LIGHT_WALK_MOST + 1 lights of each, EMITTER_NONE past the last, and
// how often walks take them.
TEST_KERNEL light_bvh_walks(__global const struct light_bvh_node *nodes,
                            __global const float4 *points, __global const float4 *normals,
                            const float draws, const uint walks, __global uint *lights,
                            __global float *expected, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    const float3 p = points[i / walks].xyz;
    const float3 normal = normals[i / walks].xyz;
    struct light_walk walk;
    light_walk_begin(&walk, nodes, p, normal, draws, rng_bits(1, i, 2, 3).x);
    for (uint k = 0; k <= LIGHT_WALK_MOST; k++) {
        float times = 0.0f;
        const uint place = i * (LIGHT_WALK_MOST + 1) + k;
        lights[place] = light_walk_next(&times, &walk, nodes, p, normal);
        expected[place] = times;
    }
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
                         normals[i / light_count].xyz, rng_unit(bits.x), rng_unit(bits.y));
        const float cosine = dot(sampled.dir, normals[i / light_count].xyz);
        if (cosine > 0.0f)
            sum = max2(sum, cosine * max3(sampled.radiance));
    }
    most[i] = sum;
}
