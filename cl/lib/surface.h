/**
 * @file
 * What a hit is a hit of: triangle, corners, texture coordinates, and what share of light it lets
 * by: by alpha, or with LAYERS by smooth thin transmission.
 */
#ifndef LIB_SURFACE_H
#define LIB_SURFACE_H

#include "lib/math.h"
#include "lib/sheen.h"
#include "lib/texture.h"
#include "shared/geometry.h"
#include "shared/material.h"
#include "shared/oct.h"
#include "shared/rng.h"

#ifndef ALPHA
#define ALPHA 1 // some material lets rays by
#endif

// Everything needed to ask about a surface; built at the head of a kernel from its arguments.
struct surface {
    __global const struct vertex *vertices;
    __global const uint2 *colors; // [vertex_count] where a material has MATERIAL_VERTEX_COLOR
    __global const struct triangle *triangles;
    __global const struct material *materials;
    __global const uint *texels; // the texture pool
};

// Blends three corners' rows by the weights of a hit.
static inline float4 surface_blend(const float4 a, const float4 b, const float4 c, const float u,
                                   const float v)
{
    return a * (1.0f - u - v) + b * u + c * v;
}

static inline float4 surface_unpack_color(const uint2 color)
{
    return (float4)((float)(color.x & 0xffffu), (float)(color.x >> 16), (float)(color.y & 0xffffu),
                    (float)(color.y >> 16)) *
           (1.0f / 65535.0f);
}

// Vertex colour at a hit.
static inline float4 surface_color(const struct surface *s, const struct triangle tri,
                                   const float u, const float v)
{
    return surface_blend(surface_unpack_color(s->colors[tri.v0]),
                         surface_unpack_color(s->colors[tri.v1]),
                         surface_unpack_color(s->colors[tri.v2]), u, v);
}

// How much of the triangle is there at this point: 0 or 1 by an alpha cut-off, or alpha itself.
static inline float surface_coverage(const struct surface *s, const uint triangle, const float u,
                                     const float v)
{
    const struct triangle tri = s->triangles[triangle];
    __global const struct material *material = &s->materials[tri.material];
    const uint flags = material->flags;
    if (!ALPHA || !(flags & (MATERIAL_MASKED | MATERIAL_BLENDED)))
        return 1.0f;
    const float4 uv =
        surface_blend(s->vertices[tri.v0].uv, s->vertices[tri.v1].uv, s->vertices[tri.v2].uv, u, v);
    float alpha = material->base.w;
    alpha *= texture_fetch_pool(s->texels, &material->textures[TEXTURE_BASE], uv).w;
    if (flags & MATERIAL_VERTEX_COLOR)
        alpha *= surface_color(s, tri, u, v).w;
    if (flags & MATERIAL_MASKED)
        return alpha >= material->emission.w ? 1.0f : 0.0f;
    return alpha;
}

#if LAYERS

// Whether nothing that goes through is scattered.
static inline bool surface_is_smooth(__global const struct material *material,
                                     const struct texture_values *values)
{
    const float roughness = material->roughness * values->surface.y;
    return (material->flags & MATERIAL_TRANSMITS) && roughness * roughness <= MATERIAL_SMOOTH;
}

#if SHEEN_LOBE

static inline float surface_sheen_roughness(__global const struct material *material,
                                            const struct texture_values *values)
{
    return max2(material->sheen.w * values->sheen_roughness.w, SHEEN_LEAST);
}

// The share of light that a sheen sends back, all colours the strongest's.
static inline float surface_sheen(__global const struct material *material,
                                  const struct texture_values *values, const float cosine)
{
    if (!(material->flags & MATERIAL_SHEEN))
        return 0.0f;
    return max3(material->sheen.xyz * values->sheen_color.xyz) *
           sheen_share(cosine, surface_sheen_roughness(material, values));
}

#endif

// The share of light that smooth thin transmission lets straight through, where the surface is.
//
//   color   vertex colour
//   cosine  between ray and interpolated normal
static inline float3 surface_straight(__global const struct material *material,
                                      const struct texture_values *values, const float3 color,
                                      const float cosine)
{
    if (!surface_is_smooth(material, values))
        return (float3)(0.0f);
    const float grazing = 1.0f - min2(fabs(cosine), 1.0f);
    const float grazing5 = grazing * grazing * grazing * grazing * grazing;
    const float strength = material->specular.w * values->specular.w;
    const float3 tint = material->specular.xyz * values->specular_color.xyz;
    const float f0 = max3(min(0.04f * tint, (float3)(1.0f))) * strength;
    const float coat = material->coat * values->coat.x * (0.04f + 0.96f * grazing5);
    const float share = material->transmission * values->transmission.x *
                        (1.0f - material->metallic * values->surface.z) *
                        (1.0f - f0 - (strength - f0) * grazing5) * (1.0f - coat);
#if SHEEN_LOBE
    const float below = 1.0f - surface_sheen(material, values, min2(fabs(cosine), 1.0f));
#else
    const float below = 1.0f;
#endif
    return material->base.xyz * values->base.xyz * color * (share * below);
}

// surface_straight() at a point of a triangle that is not shaded.
static inline float3 surface_straight_at(const struct surface *s, const struct triangle tri,
                                         __global const struct material *material, const float u,
                                         const float v, const float3 dir)
{
    const float4 row0 = s->vertices[tri.v0].pos_normal;
    const float4 row1 = s->vertices[tri.v1].pos_normal;
    const float4 row2 = s->vertices[tri.v2].pos_normal;
    const float3 blended = (1.0f - u - v) * normalize(oct_unpack(as_uint(row0.w)).xyz) +
                           u * normalize(oct_unpack(as_uint(row1.w)).xyz) +
                           v * normalize(oct_unpack(as_uint(row2.w)).xyz);
    const float cosine = dot(blended, dir) * rsqrt(max2(dot(blended, blended), 1e-20f));

    const float4 uv =
        surface_blend(s->vertices[tri.v0].uv, s->vertices[tri.v1].uv, s->vertices[tri.v2].uv, u, v);
    __global const struct texture_slot *slots = material->textures;
    struct texture_values values;
    values.base = texture_fetch_pool(s->texels, &slots[TEXTURE_BASE], uv);
    values.surface = texture_fetch_pool(s->texels, &slots[TEXTURE_SURFACE], uv);
    values.specular = texture_fetch_pool(s->texels, &slots[TEXTURE_SPECULAR], uv);
    values.specular_color = texture_fetch_pool(s->texels, &slots[TEXTURE_SPECULAR_COLOR], uv);
    values.transmission = texture_fetch_pool(s->texels, &slots[TEXTURE_TRANSMISSION], uv);
    values.coat = texture_fetch_pool(s->texels, &slots[TEXTURE_COAT], uv);
#if SHEEN_LOBE
    values.sheen_color = texture_fetch_pool(s->texels, &slots[TEXTURE_SHEEN_COLOR], uv);
    values.sheen_roughness = texture_fetch_pool(s->texels, &slots[TEXTURE_SHEEN_ROUGHNESS], uv);
#endif
    const float3 color = (material->flags & MATERIAL_VERTEX_COLOR) ? surface_color(s, tri, u, v).xyz
                                                                   : (float3)(1.0f);
    return surface_straight(material, &values, color, cosine);
}

#endif

// The share of light that goes on beyond the triangle at this point as if it were not there: where
// alpha leaves it out, and straight through what is smooth and thin.
static inline float3 surface_passes(const struct surface *s, const uint triangle, const float u,
                                    const float v, const float3 dir)
{
    const float coverage = surface_coverage(s, triangle, u, v);
    float3 passes = (float3)(1.0f - coverage);
#if LAYERS
    const struct triangle tri = s->triangles[triangle];
    __global const struct material *material = &s->materials[tri.material];
    if ((material->flags & MATERIAL_TRANSMITS) && coverage > 0.0f)
        passes += coverage * surface_straight_at(s, tri, material, u, v, dir);
#endif
    return passes;
}

// A uniform number that ray and triangle alone decide: the same for every traversal.
static inline float surface_number(const uint triangle, const float3 org, const float3 dir)
{
    uint bits = rng_mix(triangle ^ rng_mix(as_uint(org.x) ^ rng_mix(as_uint(org.y))));
    bits = rng_mix(as_uint(dir.x) ^ rng_mix(as_uint(dir.y) ^ rng_mix(as_uint(dir.z) ^ bits)));
    return rng_unit(bits);
}

// Of the largest coordinate, and m: how far off a surface rays start.
#define SURFACE_OFFSET       1.9073486e-6f // 2^-19
#define SURFACE_OFFSET_LEAST 1e-7f         // near the origin

// Where rays that leave a surface start: far enough off it on the side of the normal that the
// rounding of Woop's test (about 2^-23 of the coordinates) cannot find the surface again.
static inline float3 surface_offset(const float3 p, const float3 normal)
{
    const float largest = max2(max2(fabs(p.x), fabs(p.y)), fabs(p.z));
    return p + normal * (largest * SURFACE_OFFSET + SURFACE_OFFSET_LEAST);
}

#endif
