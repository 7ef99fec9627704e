/**
 * @file
 * The BSDF of a material at a hit, from its factors and what its textures say. lib/material_lanes.h
 * does the same for hits side by side.
 */
#ifndef LIB_MATERIAL_BSDF_H
#define LIB_MATERIAL_BSDF_H

#include "lib/bsdf.h"
#include "lib/layers.h"
#include "shared/material.h"

// Reads the two workflows into BSDF parameters.
static inline void material_bsdf(struct bsdf *b, __global const struct material *material,
                                 const struct texture_values *values, const float4 color)
{
    const float3 base = material->base.xyz * values->base.xyz * color.xyz;
    const float3 tint = material->specular.xyz;
    float glossiness;
    if (material->flags & MATERIAL_SPECULAR_GLOSSINESS) {
        const float3 specular = tint * values->surface.xyz;
        glossiness = material->glossiness * values->surface.w;
        b->diffuse = base * (1.0f - max3(specular));
        b->f0 = specular;
        b->f90 = max3(specular) > 0.0f ? 1.0f : 0.0f;
        b->dielectric_f0 = max3(specular);
        b->dielectric_f90 = b->f90;
#if BRDF_PHONG
        b->diffuse = base;
#endif
    } else {
        const float metallic = material->metallic * values->surface.z;
        const float strength = material->specular.w * values->specular.w;
        const float3 dielectric =
            min(0.04f * tint * values->specular_color.xyz, (float3)(1.0f)) * strength;
        glossiness = 1.0f - material->roughness * values->surface.y;
        b->diffuse = base * (1.0f - metallic);
        b->f0 = mix(dielectric, base, metallic);
        b->f90 = mix(strength, 1.0f, metallic);
        b->dielectric_f0 = max3(dielectric);
        b->dielectric_f90 = strength;
    }

    b->alpha = bsdf_alpha(1.0f - glossiness);
    b->mirror = false;
#if BRDF_PHONG
    b->mirror = glossiness >= 1.0f;
    b->f90 = 0.0f;
#endif
}

#endif
