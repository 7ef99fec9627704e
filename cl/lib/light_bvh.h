/**
 * @file
 * Drawing a light by its estimated contribution, from the 8-wide light BVH (prep/light_bvh.h).
 *
 * Source of the estimate: A. Conty Estevez, C. Kulla, 2018, section 4.2: power over squared
 * distance, times the largest cosines that the bounds allow at the light and at the surface.
 * Differs from it: the window of KHR_lights_punctual's range is a factor, so that lights out of
 * reach have probability 0. All bounds err on the side of more, so no light that contributes has.
 */
#ifndef LIB_LIGHT_BVH_H
#define LIB_LIGHT_BVH_H

#include "lib/math.h"
#include "shared/geometry.h"
#include "shared/light.h"
#include "shared/rng.h"

// Cosine of max(0, a - b) from cosines and sines of angles within 0 .. pi.
static inline float8 light_bvh_cos_minus(const float8 cos_a, const float8 sin_a, const float8 cos_b,
                                         const float8 sin_b)
{
    return select(cos_a * cos_b + sin_a * sin_b, (float8)(1.0f), cos_a > cos_b);
}

static inline float8 light_bvh_sine(const float8 cosine)
{
    return sqrt(max((float8)(0.0f), 1.0f - cosine * cosine));
}

// Estimates what the lights below each of a node's children send to p.
//
//   normal  unit, of the surface at p
static inline float8 light_bvh_weigh(__global const struct light_bvh_node *node, const float3 p,
                                     const float3 normal)
{
    __global const float *rows = (__global const float *)node;
    const float8 x = vload8(0, rows) - p.x;
    const float8 y = vload8(1, rows) - p.y;
    const float8 z = vload8(2, rows) - p.z;
    const float8 radius = vload8(3, rows);
    const float8 power = vload8(4, rows);
    const float8 range = vload8(5, rows);
    const float8 axis_x = vload8(6, rows);
    const float8 axis_y = vload8(7, rows);
    const float8 axis_z = vload8(8, rows);
    const float8 cos_o = vload8(9, rows);
    const float8 cos_e = vload8(10, rows);

    // Find how large the sphere looks: half its angle is b.
    const float8 radius2 = radius * radius;
    const float8 distance2 = x * x + y * y + z * z;
    const float8 apart2 = max(distance2, (float8)(1e-30f));
    const float8 distance = sqrt(apart2);
    const float8 inverse = 1.0f / distance;
    const int8 inside = distance2 <= radius2;
    const float8 sin_b = select(radius * inverse, (float8)(0.0f), inside);
    const float8 cos_b = select(light_bvh_sine(sin_b), (float8)(-1.0f), inside);

    // Bound the cosine at the lights: angle to the axis, less the cone, less the sphere.
    const float8 along = -(axis_x * x + axis_y * y + axis_z * z) * inverse;
    const float8 cos_w = select(along, fabs(along), power < 0.0f);
    const float8 cos_wo =
        light_bvh_cos_minus(cos_w, light_bvh_sine(cos_w), cos_o, light_bvh_sine(cos_o));
    const float8 cos_light = light_bvh_cos_minus(cos_wo, light_bvh_sine(cos_wo), cos_b, sin_b);

    // Bound the cosine at the surface.
    const float8 cos_n = (normal.x * x + normal.y * y + normal.z * z) * inverse;
    const float8 cos_surface = light_bvh_cos_minus(cos_n, light_bvh_sine(cos_n), cos_b, sin_b);

    // Window the range at the nearest that a light can be.
    const float8 near = max(distance - radius, (float8)(0.0f)) / range;
    const float8 near2 = near * near;
    const float8 window = 1.0f - near2 * near2;

    const float8 lit = max(cos_light, (float8)(1e-3f)); // at the very edge of a cone
    const float8 weight = fabs(power) * lit * cos_surface * window / max(apart2, radius2);
    const int8 dark = cos_light <= cos_e || cos_surface <= 0.0f || near >= 1.0f;
    return select(weight, (float8)(0.0f), dark);
}

// Draws one light.
//
//   pmf   out: its probability
//   bits  32 random bits: their order is kept, near numbers draw near lights
// Returns its index, or EMITTER_NONE where no light can contribute.
static inline uint light_bvh_draw(float *pmf, __global const struct light_bvh_node *nodes,
                                  const float3 p, const float3 normal, uint bits)
{
    float number = rng_unit(bits);
    *pmf = 1.0f;
    uint word = 0;
    do {
        float weights[8];
        __global const struct light_bvh_node *node = &nodes[word];
        const float8 weight = light_bvh_weigh(node, p, normal);
        vstore8(weight, 0, weights);
        float sum = 0.0f;
        for (int i = 0; i < 8; i++)
            sum += weights[i];
        if (!(sum > 0.0f))
            return EMITTER_NONE;

        // Take the child in whose part of the sum the number falls.
        float left = number * sum;
        float rest = left;
        int child = -1;
        for (int i = 0; i < 8; i++) {
            if (weights[i] > 0.0f && left >= 0.0f) {
                child = i;
                rest = left;
            }
            left -= weights[i];
        }

        // Where the number lies in that part is the next one, with new bits for those used up.
        bits = rng_mix(bits);
        number = min2((rest + rng_unit(bits) * sum * RNG_UNIT_STEP) / weights[child], RNG_UNIT_MAX);
        *pmf *= weights[child] / sum;
        word = ((__global const uint *)node)[11 * 8 + child];
    } while (!(word & LIGHT_BVH_LEAF));
    return word & ~LIGHT_BVH_LEAF;
}

// The probability with which light_bvh_draw() comes to this light: walks up from its leaf.
static inline float light_bvh_pmf(__global const struct light_bvh_node *nodes,
                                  __global const uint *parents, __global const uint *leaves,
                                  const float3 p, const float3 normal, const uint light)
{
    float pmf = 1.0f;
    for (uint place = leaves[light]; place != LIGHT_BVH_ROOT; place = parents[place >> 3]) {
        float weights[8];
        vstore8(light_bvh_weigh(&nodes[place >> 3], p, normal), 0, weights);
        float sum = 0.0f;
        for (int i = 0; i < 8; i++)
            sum += weights[i];
        if (!(weights[place & 7u] > 0.0f))
            return 0.0f;
        pmf *= weights[place & 7u] / sum;
    }
    return pmf;
}

#endif
