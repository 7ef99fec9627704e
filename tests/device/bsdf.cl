// lib/bsdf.h, with its parameters read from a material as the material stage does.
//
// Variants: BRDF_PHONG; SHEEN_LOBE evaluates the sheen alone.

#include "bsdf_case.h"
#include "material.cl"
#include "test.h"

static inline struct bsdf bsdf_of_case(__global const struct bsdf_case *c)
{
    struct texture_values white;
    white.base = (float4)(1.0f);
    white.surface = (float4)(1.0f);
    white.emissive = (float4)(1.0f);
    white.specular = (float4)(1.0f);
    white.specular_color = (float4)(1.0f);
    struct bsdf b;
    b.normal = c->normal.xyz;
    b.geometric = c->geometric.xyz;
    b.view = c->view.xyz;
    material_bsdf(&b, &c->material, &white, (float4)(1.0f));
#if LAYERS && SHEEN_LOBE
    white.sheen_roughness = (float4)(1.0f);
    layer_clear(&b);
    b.alpha = -surface_sheen_roughness(&c->material, &white);
    b.f0 = c->material.sheen.xyz;
#endif
    return b;
}

// out: rgb f cos, w density, of each direction.
TEST_KERNEL bsdf_values(__global const struct bsdf_case *c, __global const float4 *dirs,
                        const uint count, __global float4 *out)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    const struct bsdf b = bsdf_of_case(c);
    float density;
    const float3 value = bsdf_eval(&density, &b, dirs[i].xyz);
    out[i] = (float4)(value, density);
}

TEST_KERNEL bsdf_draws(__global const struct bsdf_case *c, __global const float4 *numbers,
                       const uint count, __global struct bsdf_draw *out)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    const struct bsdf b = bsdf_of_case(c);
    const struct bsdf_sample sampled = bsdf_sample(&b, numbers[i].xyz);
    out[i].dir_density = (float4)(sampled.dir, sampled.density);
    out[i].weight = (float4)(sampled.weight, sampled.specular ? 1.0f : 0.0f);
}
