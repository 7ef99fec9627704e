/**
 * @file
 * Texture lookup: bilinear or nearest, by hand, so that sRGB is decoded before filtering and every
 * device filters alike.
 *
 * Texels come from the pool of all textures (a buffer), or with TEXTURE_IMAGES from one image bound
 * for this launch.
 */
#ifndef LIB_TEXTURE_H
#define LIB_TEXTURE_H

#include "lib/srgb.h"
#include "shared/material.h"

// What the textures of a material say at one point.
struct texture_values {
    float4 base, surface, emissive, specular, specular_color;
#if NORMAL_MAPS
    float4 normal;
#endif
#if LAYERS
    float4 transmission, diffuse_transmission, diffuse_transmission_color;
    float4 coat, coat_roughness;
#if NORMAL_MAPS
    float4 coat_normal;
#endif
#endif
#if SHEEN_LOBE
    float4 sheen_color, sheen_roughness;
#endif
};

// Where the two texels of one axis lie, and how far between them the point is.
struct texture_taps {
    int near, far;
    float blend; // 0 .. 1: weight of far
};

// Brings one coordinate into the texture.
static inline struct texture_taps texture_wrap_axis(float u, const int size, const uint wrap,
                                                    const bool nearest)
{
    if (wrap == TEXTURE_WRAP_CLAMP) {
        u = clamp(u, 0.0f, 1.0f);
    } else if (wrap == TEXTURE_WRAP_MIRROR) {
        u -= 2.0f * floor(0.5f * u);
        u = u > 1.0f ? 2.0f - u : u;
    } else {
        u -= floor(u);
    }

    struct texture_taps taps;
    const float x = u * (float)size - (nearest ? 0.0f : 0.5f);
    const float cell = floor(x);
    taps.near = (int)cell;
    taps.far = taps.near + 1;
    taps.blend = nearest ? 0.0f : x - cell;
    if (wrap == TEXTURE_WRAP_REPEAT) {
        taps.near = taps.near < 0 ? size - 1 : (taps.near >= size ? 0 : taps.near);
        taps.far = taps.far >= size ? taps.far - size : taps.far;
    }
    taps.near = clamp(taps.near, 0, size - 1);
    taps.far = clamp(taps.far, 0, size - 1);
    return taps;
}

static inline float4 texture_decode(const uint texel, const bool srgb)
{
    const uint r = texel & 255u;
    const uint g = (texel >> 8) & 255u;
    const uint b = (texel >> 16) & 255u;
    const float a = (float)(texel >> 24) * (1.0f / 255.0f);
    if (srgb)
        return (float4)(srgb_decode(r), srgb_decode(g), srgb_decode(b), a);
    return (float4)((float)r * (1.0f / 255.0f), (float)g * (1.0f / 255.0f),
                    (float)b * (1.0f / 255.0f), a);
}

#if TEXTURE_IMAGES
#define TEXTURE_SOURCE __read_only image2d_t
#else
#define TEXTURE_SOURCE __global const uint *restrict
#endif

// One texel of the pool.
static inline uint texture_texel_pool(__global const uint *restrict texels, const uint first,
                                      const int width, const int x, const int y)
{
    return texels[first + (uint)y * (uint)width + (uint)x];
}

// Filters four texels.
static inline float4 texture_blend(const uint t00, const uint t10, const uint t01, const uint t11,
                                   const float x, const float y, const bool srgb)
{
    const float4 top = mix(texture_decode(t00, srgb), texture_decode(t10, srgb), x);
    const float4 bottom = mix(texture_decode(t01, srgb), texture_decode(t11, srgb), x);
    return mix(top, bottom, y);
}

// The UV that a slot asks for: its set, transformed.
static inline float2 texture_uv(__global const struct texture_slot *slot, const float4 uv)
{
    const float2 at = (slot->flags & TEXTURE_UV1) ? uv.zw : uv.xy;
    const float4 m = slot->uv_matrix;
    return (float2)(m.x * at.x + m.y * at.y, m.z * at.x + m.w * at.y) + slot->uv_offset;
}

// The value of a slot at a surface point, from the pool; 1, 1, 1, 1 without a texture.
//
//   uv  xy TEXCOORD_0, zw TEXCOORD_1
static inline float4 texture_fetch_pool(__global const uint *restrict texels,
                                        __global const struct texture_slot *slot, const float4 uv)
{
    const uint flags = slot->flags;
    if (!(flags & TEXTURE_PRESENT))
        return (float4)(1.0f);

    const float2 at = texture_uv(slot, uv);
    const int width = (int)(slot->size & 0xffffu);
    const int height = (int)(slot->size >> 16);
    const bool nearest = (flags & TEXTURE_NEAREST) != 0;
    const bool srgb = (flags & TEXTURE_SRGB) != 0;
    const uint first = slot->texel_first;
    const struct texture_taps x =
        texture_wrap_axis(at.x, width, (flags >> TEXTURE_WRAP_S_SHIFT) & 3u, nearest);
    const struct texture_taps y =
        texture_wrap_axis(at.y, height, (flags >> TEXTURE_WRAP_T_SHIFT) & 3u, nearest);
    const uint t00 = texture_texel_pool(texels, first, width, x.near, y.near);
    if (nearest)
        return texture_decode(t00, srgb);
    return texture_blend(t00, texture_texel_pool(texels, first, width, x.far, y.near),
                         texture_texel_pool(texels, first, width, x.near, y.far),
                         texture_texel_pool(texels, first, width, x.far, y.far), x.blend, y.blend,
                         srgb);
}

#if TEXTURE_IMAGES

__constant sampler_t texture_sampler =
    CLK_NORMALIZED_COORDS_FALSE | CLK_ADDRESS_CLAMP_TO_EDGE | CLK_FILTER_NEAREST;

// One texel of the bound image, packed as in the pool.
static inline uint texture_texel_image(__read_only image2d_t image, const int x, const int y)
{
    const uint4 t = read_imageui(image, texture_sampler, (int2)(x, y));
    return t.x | (t.y << 8) | (t.z << 16) | (t.w << 24);
}

// As texture_fetch_pool(), from the image bound for this slot.
static inline float4 texture_fetch(__read_only image2d_t image,
                                   __global const struct texture_slot *slot, const float4 uv)
{
    const uint flags = slot->flags;
    if (!(flags & TEXTURE_PRESENT))
        return (float4)(1.0f);

    const float2 at = texture_uv(slot, uv);
    const int width = (int)(slot->size & 0xffffu);
    const int height = (int)(slot->size >> 16);
    const bool nearest = (flags & TEXTURE_NEAREST) != 0;
    const bool srgb = (flags & TEXTURE_SRGB) != 0;
    const struct texture_taps x =
        texture_wrap_axis(at.x, width, (flags >> TEXTURE_WRAP_S_SHIFT) & 3u, nearest);
    const struct texture_taps y =
        texture_wrap_axis(at.y, height, (flags >> TEXTURE_WRAP_T_SHIFT) & 3u, nearest);
    const uint t00 = texture_texel_image(image, x.near, y.near);
    if (nearest)
        return texture_decode(t00, srgb);
    return texture_blend(t00, texture_texel_image(image, x.far, y.near),
                         texture_texel_image(image, x.near, y.far),
                         texture_texel_image(image, x.far, y.far), x.blend, y.blend, srgb);
}

#else
#define texture_fetch texture_fetch_pool
#endif

#endif
