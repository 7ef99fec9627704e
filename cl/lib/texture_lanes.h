/**
 * @file
 * texture_fetch_pool() of lib/texture.h for eight hits side by side, each with a texture of its
 * own.
 */
#ifndef LIB_TEXTURE_LANES_H
#define LIB_TEXTURE_LANES_H

#include "lib/lanes.h"
#include "lib/prefetch.h"
#include "lib/texture.h"

// Where the texels lie that eight hits look up.
struct texture_lanes {
    uint near_near[LANES], far_near[LANES]; // places in the pool, by column and row
    uint near_far[LANES], far_far[LANES];
    float8 x, y; // weights of the far columns and rows
    int8 srgb;
};

// The texels of one axis: struct texture_taps.
struct texture_lanes_taps {
    int8 near, far;
    float8 blend;
};

// texture_wrap_axis()
static inline struct texture_lanes_taps texture_lanes_wrap_axis(const float8 u, const int8 size,
                                                                const uint8 wrap,
                                                                const int8 nearest)
{
    const int8 repeats = wrap == TEXTURE_WRAP_REPEAT;
    float8 at = u - lanes_floor(u);
    if (lanes_bits(repeats) != 0xffu) {
        const float8 mirrored = u - 2.0f * lanes_floor(0.5f * u);
        const float8 turned = mirrored > 1.0f ? 2.0f - mirrored : mirrored;
        const float8 clamped = min8(max8(u, (float8)(0.0f)), (float8)(1.0f));
        at = repeats ? at : wrap == TEXTURE_WRAP_MIRROR ? turned : clamped;
    }

    struct texture_lanes_taps taps;
    const int8 last = size - 1;
    const float8 x = at * convert_float8(size) - (nearest ? (float8)(0.0f) : (float8)(0.5f));
    const float8 cell = lanes_floor(x);
    const int8 near = convert_int8(cell);
    const int8 far = near + 1;
    taps.blend = nearest ? (float8)(0.0f) : x - cell;
    // Beyond an end is the other one, or the same.
    const int8 zero = (int8)(0);
    taps.near = near < zero ? (repeats ? last : zero) : near;
    taps.near = near > last ? (repeats ? zero : last) : taps.near;
    taps.far = far > last ? (repeats ? far - size : last) : far;
    taps.far = min(max(taps.far, zero), last);
    return taps;
}

// Finds the texels of those lanes that have a bit; the others look up the pool's first.
//
//   material  of each lane
//   use       of its textures
//   uv        xy TEXCOORD_0, zw TEXCOORD_1
static inline void texture_lanes_find(struct texture_lanes *out,
                                      __global const struct material *materials,
                                      const uint *material, const uint use, const uint bits,
                                      const struct lanes4 uv)
{
    const uint8 flags = LANES_WORD(uint8, materials, material, .textures[use].flags);
    const uint8 size = LANES_WORD(uint8, materials, material, .textures[use].size);
    const uint8 first = LANES_WORD(uint8, materials, material, .textures[use].texel_first);
    const struct lanes4 m = LANES_OF(materials, material, .textures[use].uv_matrix);
    const float8 move_x = LANES_WORD(float8, materials, material, .textures[use].uv_offset.x);
    const float8 move_y = LANES_WORD(float8, materials, material, .textures[use].uv_offset.y);

    // Find the columns and the rows.
    const int8 second = (flags & TEXTURE_UV1) != 0u;
    const float8 u = second ? uv.z : uv.x;
    const float8 v = second ? uv.w : uv.y;
    const int8 nearest = (flags & TEXTURE_NEAREST) != 0u;
    const uint8 width = size & 0xffffu;
    const struct texture_lanes_taps x = texture_lanes_wrap_axis(
        m.x * u + m.y * v + move_x, as_int8(width), (flags >> TEXTURE_WRAP_S_SHIFT) & 3u, nearest);
    const struct texture_lanes_taps y =
        texture_lanes_wrap_axis(m.z * u + m.w * v + move_y, as_int8(size >> 16),
                                (flags >> TEXTURE_WRAP_T_SHIFT) & 3u, nearest);

    // Find their places in the pool.
    const int8 own = lanes_mask(bits);
    const uint8 near_row = first + as_uint8(y.near) * width;
    const uint8 far_row = first + as_uint8(y.far) * width;
    const uint8 zero = (uint8)(0u);
    vstore8(own ? near_row + as_uint8(x.near) : zero, 0, out->near_near);
    vstore8(own ? near_row + as_uint8(x.far) : zero, 0, out->far_near);
    vstore8(own ? far_row + as_uint8(x.near) : zero, 0, out->near_far);
    vstore8(own ? far_row + as_uint8(x.far) : zero, 0, out->far_far);
    out->x = x.blend;
    out->y = y.blend;
    out->srgb = (flags & TEXTURE_SRGB) != 0u;
}

#if PREFETCHES

// Asks for the texels that texture_lanes_fetch() will read.
static inline void texture_lanes_warm(const struct texture_lanes *lanes, uint bits,
                                      __global const uint *texels)
{
    for (; bits != 0; bits &= bits - 1) {
        const uint k = lanes_lowest(bits);
        PREFETCH(&texels[lanes->near_near[k]]);
        PREFETCH(&texels[lanes->near_far[k]]);
    }
}

#endif

// One channel of eight texels, decoded; `shift` is the place of its bits.
static inline float8 texture_lanes_decode(const uint8 texel, const uint shift, const int8 srgb)
{
    const uint8 code = (texel >> shift) & 255u;
    const float8 linear = convert_float8(as_int8(code)) * (1.0f / 255.0f);
    if (lanes_bits(srgb) == 0)
        return linear;
    const float8 decoded =
        (float8)(srgb_decode(code.s0), srgb_decode(code.s1), srgb_decode(code.s2),
                 srgb_decode(code.s3), srgb_decode(code.s4), srgb_decode(code.s5),
                 srgb_decode(code.s6), srgb_decode(code.s7));
    return srgb ? decoded : linear;
}

// Filters one channel of four texels.
static inline float8 texture_lanes_blend(const struct texture_lanes *lanes, const uint8 t00,
                                         const uint8 t10, const uint8 t01, const uint8 t11,
                                         const uint shift)
{
    const float8 top = mix(texture_lanes_decode(t00, shift, lanes->srgb),
                           texture_lanes_decode(t10, shift, lanes->srgb), lanes->x);
    const float8 bottom = mix(texture_lanes_decode(t01, shift, lanes->srgb),
                              texture_lanes_decode(t11, shift, lanes->srgb), lanes->x);
    return mix(top, bottom, lanes->y);
}

// The colours of the texels that were found; 1, 1, 1 in lanes without a bit.
static inline struct lanes3 texture_lanes_fetch(const struct texture_lanes *lanes, const uint bits,
                                                __global const uint *texels)
{
    const uint8 t00 = LANES_WORD(uint8, texels, lanes->near_near, );
    const uint8 t10 = LANES_WORD(uint8, texels, lanes->far_near, );
    const uint8 t01 = LANES_WORD(uint8, texels, lanes->near_far, );
    const uint8 t11 = LANES_WORD(uint8, texels, lanes->far_far, );
    const float8 one = (float8)(1.0f);
    return lanes3_select(lanes_mask(bits),
                         lanes3_make(texture_lanes_blend(lanes, t00, t10, t01, t11, 0),
                                     texture_lanes_blend(lanes, t00, t10, t01, t11, 8),
                                     texture_lanes_blend(lanes, t00, t10, t01, t11, 16)),
                         lanes3_make(one, one, one));
}

#endif
