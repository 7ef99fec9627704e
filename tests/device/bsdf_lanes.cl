// lib/bsdf_lanes.h: what bsdf.cl makes of a case by lib/bsdf.h.

#define SHADE_LANES 1

#include "bsdf_case.h"
#include "lib/bsdf.h"
#include "lib/bsdf_lanes.h"
#include "lib/material_bsdf.h"
#include "test.h"

static inline struct lanes3 lanes_of(const float3 v)
{
    return lanes3_make((lanes_float)(v.x), (lanes_float)(v.y), (lanes_float)(v.z));
}

static inline struct bsdf_lanes bsdf_of_case(__global const struct bsdf_case *c)
{
    struct texture_values white;
    white.base = (float4)(1.0f);
    white.surface = (float4)(1.0f);
    white.emissive = (float4)(1.0f);
    white.specular = (float4)(1.0f);
    white.specular_color = (float4)(1.0f);
    struct bsdf single;
    material_bsdf(&single, &c->material, &white, (float4)(1.0f));
    struct bsdf_lanes b;
    b.normal = lanes_of(c->normal.xyz);
    b.geometric = lanes_of(c->geometric.xyz);
    b.view = lanes_of(c->view.xyz);
    b.diffuse = lanes_of(single.diffuse);
    b.glossy = bsdf_is_lambert(&single) ? 0u : LANES_ALL;
    b.f0 = lanes_of(single.f0);
    b.f90 = (lanes_float)(single.f90);
    b.alpha = (lanes_float)(single.alpha);
    b.dielectric_f0 = (lanes_float)(single.dielectric_f0);
    b.dielectric_f90 = (lanes_float)(single.dielectric_f90);
    b.share = bsdf_lanes_share(&b);
    return b;
}

static inline lanes_int is_above(const struct bsdf_lanes *b, const struct lanes3 dir)
{
    return (lanes3_dot(b->normal, dir) > 0.0f) & (lanes3_dot(b->geometric, dir) > 0.0f);
}

// Whether lanes beside others get what they get among their like: half of them are made Lambert.
static inline lanes_int is_kept(const struct bsdf_lanes *b, const struct lanes3 dir)
{
    struct bsdf_lanes mixed = *b;
    struct bsdf_lanes lambert = *b;
    lanes_float density, mixed_density, lambert_density;
    mixed.glossy &= 0x5a5au;
    lambert.glossy = 0;
    const struct lanes3 value = bsdf_lanes_eval(&density, b, dir);
    const struct lanes3 mixed_value = bsdf_lanes_eval(&mixed_density, &mixed, dir);
    const struct lanes3 lambert_value = bsdf_lanes_eval(&lambert_density, &lambert, dir);
    const lanes_int glossy = lanes_mask(mixed.glossy);
    const struct lanes3 expected = lanes3_select(glossy, value, lambert_value);
    return (mixed_density == (glossy ? density : lambert_density)) & (mixed_value.x == expected.x) &
           (mixed_value.y == expected.y) & (mixed_value.z == expected.z);
}

// LANES directions an item; count is a multiple.
TEST_KERNEL bsdf_values(__global const struct bsdf_case *c, __global const float4 *dirs,
                        const uint count, __global float4 *out)
{
    const uint first = get_global_id(0) * LANES;
    if (first >= count)
        return;
    const struct bsdf_lanes b = bsdf_of_case(c);
    uint places[LANES];
    lanes_store(first + lanes_as_uint(LANES_ORDER), places);
    const struct lanes3 dir = lanes3_xyz(LANES_OF(dirs, places, ));
    lanes_float density;
    const struct lanes3 value = bsdf_lanes_eval(&density, &b, dir);
    const lanes_int above = is_above(&b, dir);
    const lanes_float zero = (lanes_float)(0.0f);
    LANES_STORE(out, places, , LANES_ALL,
                lanes4_make(lanes3_select(above, value, lanes3_make(zero, zero, zero)),
                            above ? (is_kept(&b, dir) ? density : zero - 1.0f) : zero));
}

TEST_KERNEL bsdf_draws(__global const struct bsdf_case *c, __global const float4 *numbers,
                       const uint count, __global struct bsdf_draw *out)
{
    const uint first = get_global_id(0) * LANES;
    if (first >= count)
        return;
    const struct bsdf_lanes b = bsdf_of_case(c);
    uint places[LANES];
    lanes_store(first + lanes_as_uint(LANES_ORDER), places);
    const struct lanes4 u = LANES_OF(numbers, places, );
    const struct lanes3 dir = bsdf_lanes_draw(&b, u.x, u.y, u.z);
    lanes_float density;
    const struct lanes3 weight = bsdf_lanes_weigh(&density, &b, dir);
    const lanes_int above = is_above(&b, dir);
    const lanes_float zero = (lanes_float)(0.0f);
    const struct lanes3 none = lanes3_make(zero, zero, zero);
    LANES_STORE(out, places, .dir_density, LANES_ALL,
                lanes4_make(lanes3_select(above, dir, none), above ? density : zero));
    LANES_STORE(out, places, .weight, LANES_ALL,
                lanes4_make(lanes3_select(above, weight, none), zero));
}
