/**
 * @file
 * What may lie above a material's base, or let light through it: clearcoat, under it sheen
 * (SHEEN_LOBE), and the transmission of thin surfaces, specular and diffuse.
 *
 * Source: KHR_materials_clearcoat, _sheen, _transmission and _diffuse_transmission. Each hit takes
 * one part of the mixture by chance and shades it alone, divided by its probability. What goes
 * through is the reflection of the mirrored view on the other side, which is how the extension
 * defines it, so that every other stage sees an ordinary BSDF. What goes straight through smooth
 * surfaces is left to traversal: see surface_straight().
 * Differs from them: neither clearcoat nor sheen dims emission; a sheen dims what is below it by
 * what it sends back to the view, not by the more of that and of what it sends back of the light.
 */
#ifndef LIB_LAYERS_H
#define LIB_LAYERS_H

#include "lib/bsdf.h"
#include "lib/surface.h"
#include "lib/texture_use.h"

#if LAYERS

#define LAYER_LEAST 0.25f // probability of taking a clearcoat, where there is any, at least

// Takes all lobes off.
static inline void layer_clear(struct bsdf *b)
{
    b->diffuse = (float3)(0.0f);
    b->f0 = (float3)(0.0f);
    b->f90 = 0.0f;
    b->dielectric_f0 = 0.0f;
    b->dielectric_f90 = 0.0f;
    b->mirror = false;
}

// Goes to the other side, where the mirrored view is.
static inline void layer_turn(struct bsdf *b)
{
    b->view -= 2.0f * dot(b->normal, b->view) * b->normal;
    b->normal = -b->normal;
    b->geometric = -b->geometric;
}

// Chooses between what the base reflects and what it lets through.
//
//   u  uniform, which part
// Returns the weight of what is left in b.
static inline float3 layer_choose_side(struct bsdf *b, __global const struct material *material,
                                       const struct texture_values *values, const float3 color,
                                       const float u)
{
    const float metallic = material->metallic * values->surface.z;
    const float specular = material->transmission * values->transmission.x;
    const float diffuse = material->diffuse_transmission.w * values->diffuse_transmission.w;
    const bool rough = !surface_is_smooth(material, values);
    const float3 base = material->base.xyz * values->base.xyz * color;
    const float3 blurred = rough ? base * ((1.0f - metallic) * specular) : (float3)(0.0f);
    const float3 scattered = material->diffuse_transmission.xyz *
                             values->diffuse_transmission_color.xyz *
                             ((1.0f - metallic) * (1.0f - specular) * diffuse);
    b->diffuse *= (1.0f - specular) * (1.0f - diffuse);

    // Choose in proportion to what each sends on, seen from here.
    const float nov = max2(dot(b->normal, b->view), 0.0f);
#if BRDF_PHONG
    const float below = 1.0f;
    const float reflected = luminance(b->f0) + luminance(b->diffuse);
    (void)nov;
#else
    const float grazing = bsdf_fifth_power(1.0f - nov);
    const float below = bsdf_base_share(b, grazing);
    const float reflected =
        luminance(b->f0 + ((float3)(b->f90) - b->f0) * grazing) + luminance(b->diffuse) * below;
#endif
    const float p_scattered = luminance(scattered) * below;
    const float p_blurred = luminance(blurred) * below;
    const float sum = reflected + p_scattered + p_blurred;
    const float place = u * sum;
    if (place < reflected || sum <= 0.0f)
        return (float3)(reflected > 0.0f ? sum / reflected : 1.0f);

    layer_turn(b);
    const float f0 = b->dielectric_f0;
    const float f90 = b->dielectric_f90;
    layer_clear(b);
    if (place < reflected + p_scattered) {
        b->diffuse = scattered;
#if !BRDF_PHONG
        b->dielectric_f0 = f0;
        b->dielectric_f90 = f90;
#endif
        return (float3)(sum / p_scattered);
    }
#if BRDF_PHONG
    b->f0 = (float3)(1.0f);
    (void)f0;
    (void)f90;
#else
    b->f0 = (float3)(1.0f - f0);
    b->f90 = 1.0f - f90;
#endif
    return blurred * (sum / p_blurred);
}

// Leaves one part of the mixture in b.
//
//   b            the base, all of it reflecting
//   color        vertex colour
//   normal       interpolated, viewer's side
//   coat_normal  the clearcoat's, viewer's side
//   u            uniform, which part
// Returns the weight of what is left.
static inline float3 layer_choose(struct bsdf *b, __global const struct material *material,
                                  const struct texture_values *values, const float4 color,
                                  const float3 normal, const float3 coat_normal, float u)
{
    float3 weight = (float3)(1.0f);

    // What smooth transmission lets by has not come here: the rest makes up for the rays gone by.
    if (material->flags & MATERIAL_TRANSMITS) {
        const float alpha = material->base.w * values->base.w * color.w;
        const float there = (material->flags & MATERIAL_BLENDED) ? alpha : 1.0f;
        const float3 straight =
            surface_straight(material, values, color.xyz, dot(normal, b->view)) * there;
        weight *= there / max2(there - max3(straight), 1e-6f);
    }

    const float coat = material->coat * values->coat.x;
    if (coat > 0.0f) {
        const float grazing = bsdf_fifth_power(1.0f - max2(dot(coat_normal, b->view), 0.0f));
        const float share = coat * (0.04f + 0.96f * grazing);
        const float chance = max2(share, LAYER_LEAST);
        if (u < chance) {
            layer_clear(b);
            b->normal = coat_normal;
            b->normal = bsdf_bend_normal(b);
            b->alpha = bsdf_alpha(material->coat_roughness * values->coat_roughness.y);
            b->f0 = (float3)(1.0f);
#if !BRDF_PHONG
            b->f90 = 1.0f;
#endif
            return weight * (share / chance);
        }
        u = (u - chance) / (1.0f - chance);
        weight *= (1.0f - share) / (1.0f - chance);
    }

#if SHEEN_LOBE
    const float share = surface_sheen(material, values, dot(b->normal, b->view));
    if (share > 0.0f) {
        const float chance = clamp(share, LAYER_LEAST, 1.0f - LAYER_LEAST);
        if (u < chance) {
            layer_clear(b);
            b->alpha = -surface_sheen_roughness(material, values);
            b->f0 = material->sheen.xyz * values->sheen_color.xyz;
            return weight / chance;
        }
        u = (u - chance) / (1.0f - chance);
        weight *= (1.0f - share) / (1.0f - chance);
    }
#endif

    return weight * layer_choose_side(b, material, values, color.xyz, u);
}

#if !TEXTURE_IMAGES

// Fetches what only layers need, from the pool.
static inline void layer_fetch(struct texture_values *values, __global const uint *restrict texels,
                               __global const struct material *material, const float4 uv)
{
    values->transmission = texture_fetch_use(texels, material, TEXTURE_TRANSMISSION, uv);
    values->diffuse_transmission =
        texture_fetch_use(texels, material, TEXTURE_DIFFUSE_TRANSMISSION, uv);
    values->diffuse_transmission_color =
        texture_fetch_use(texels, material, TEXTURE_DIFFUSE_TRANSMISSION_COLOR, uv);
    values->coat = texture_fetch_use(texels, material, TEXTURE_COAT, uv);
    values->coat_roughness = texture_fetch_use(texels, material, TEXTURE_COAT_ROUGHNESS, uv);
#if NORMAL_MAPS
    values->coat_normal = texture_fetch_use(texels, material, TEXTURE_COAT_NORMAL, uv);
#endif
#if SHEEN_LOBE
    values->sheen_color = texture_fetch_use(texels, material, TEXTURE_SHEEN_COLOR, uv);
    values->sheen_roughness = texture_fetch_use(texels, material, TEXTURE_SHEEN_ROUGHNESS, uv);
#endif
}

#endif

#endif
#endif
