/**
 * @file
 * What a hit is a hit of: triangle, corners, texture coordinates, and whether alpha lets the ray
 * by.
 */
#ifndef LIB_SURFACE_H
#define LIB_SURFACE_H

#include "lib/math.h"
#include "lib/texture.h"
#include "shared/geometry.h"
#include "shared/material.h"
#include "shared/rng.h"

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
    if (!(flags & (MATERIAL_MASKED | MATERIAL_BLENDED)))
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

// Whether a ray meets the triangle at this point. Where it is partly there, that share of rays
// does, drawn by a number that ray and triangle alone decide: the same for every traversal.
static inline bool surface_meets(const struct surface *s, const uint triangle, const float u,
                                 const float v, const float3 org, const float3 dir)
{
    const float coverage = surface_coverage(s, triangle, u, v);
    if (coverage >= 1.0f || coverage <= 0.0f)
        return coverage > 0.0f;
    uint bits = rng_mix(triangle ^ rng_mix(as_uint(org.x) ^ rng_mix(as_uint(org.y))));
    bits = rng_mix(as_uint(dir.x) ^ rng_mix(as_uint(dir.y) ^ rng_mix(as_uint(dir.z) ^ bits)));
    return rng_unit(bits) < coverage;
}

// Where rays that leave a surface start: far enough off it on the side of the normal that the
// rounding of Woop's test (about 2^-23 of the coordinates) cannot find the surface again.
static inline float3 surface_offset(const float3 p, const float3 normal)
{
    const float largest = max2(max2(fabs(p.x), fabs(p.y)), fabs(p.z));
    return p + normal * (largest * 1.9073486e-6f + 1e-7f); // 2^-19 of it; a floor near the origin
}

#endif
