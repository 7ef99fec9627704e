/**
 * @file
 * Random lights of every type, and the light BVH over them.
 */
#ifndef TESTS_PREP_LIGHT_FIXTURE_H
#define TESTS_PREP_LIGHT_FIXTURE_H

#include <math.h>

#include "prep/light_bvh.h"
#include "prep_support.h"

struct light_fixture {
    struct light *lights;
    struct light_shape *shapes;
    float *power;
    struct light_bvh bvh;
    uint32_t count;
};

static inline float bits_to_float(uint bits)
{
    float value;
    memcpy(&value, &bits, sizeof(value));
    return value;
}

static inline uint float_to_bits(float value)
{
    uint bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

static inline float4 random_row(uint64_t *seed, double reach)
{
    return (float4){(float)random_between(seed, -reach, reach),
                    (float)random_between(seed, -reach, reach),
                    (float)random_between(seed, -reach, reach), 0.0f};
}

static inline double length_of(float4 v)
{
    return sqrt((double)v.x * v.x + (double)v.y * v.y + (double)v.z * v.z);
}

// A light of a type somewhere within +-20 m.
static inline void make_light(struct light_fixture *out, uint32_t i, uint type, uint64_t *seed)
{
    struct light *light = &out->lights[i];
    struct light_shape *shape = &out->shapes[i];
    const double bright = random_between(seed, 0.1, 10.0);
    uint kind = type | i << LIGHT_SHAPE_SHIFT;
    light->org_range = random_row(seed, 20.0);
    light->color_kind = (float4){(float)bright, (float)bright, (float)bright, 0.0f};
    out->power[i] = (float)(4.0 * M_PI * bright);
    shape->edge_u = random_row(seed, 1.0);
    shape->edge_v = random_row(seed, 1.0);
    if (type == LIGHT_POINT || type == LIGHT_SPOT)
        light->org_range.w = i % 3 == 0 ? LIGHT_NO_RANGE : (float)random_between(seed, 1.0, 9.0);
    if (type == LIGHT_SPOT) {
        const float scale = (float)(1.0 / length_of(shape->edge_u));
        shape->edge_u.x *= scale;
        shape->edge_u.y *= scale;
        shape->edge_u.z *= scale;
        shape->edge_u.w = 2.0f;
        shape->edge_v.w = -2.0f * (float)random_unit(seed);
    } else if (type != LIGHT_POINT && i % 2 == 0) {
        kind |= LIGHT_TWO_SIDED;
    }
    light->color_kind.w = bits_to_float(kind);
}

static inline void light_fixture_build(struct light_fixture *out, uint32_t count, uint type_count,
                                       uint64_t seed)
{
    *out = (struct light_fixture){.count = count};
    out->lights = calloc(count, sizeof(*out->lights));
    out->shapes = calloc(count, sizeof(*out->shapes));
    out->power = calloc(count, sizeof(*out->power));
    for (uint32_t i = 0; i < count; i++)
        make_light(out, i, i % type_count, &seed);
    const enum status status =
        light_bvh_build(&out->bvh, out->lights, out->shapes, out->power, count);
    if (status != STATUS_OK)
        abort();
}

static inline void light_fixture_free(struct light_fixture *fixture)
{
    light_bvh_free(&fixture->bvh);
    free(fixture->power);
    free(fixture->shapes);
    free(fixture->lights);
}

#endif
