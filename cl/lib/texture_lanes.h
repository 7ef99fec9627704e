/**
 * @file
 * texture_fetch_pool() of lib/texture.h for hits side by side, each with a texture of its
 * own.
 */
#ifndef LIB_TEXTURE_LANES_H
#define LIB_TEXTURE_LANES_H

#include "lib/lanes.h"
#include "lib/prefetch.h"
#include "lib/texture.h"

// Where the texels lie that hits look up.
struct texture_lanes {
    uint near_near[LANES], far_near[LANES]; // places in the pool, by column and row
    uint near_far[LANES], far_far[LANES];
    lanes_float x, y; // weights of the far columns and rows
    lanes_int srgb;
};

// Four texels of each lane.
struct texture_lanes_texels {
    lanes_uint near_near, far_near, near_far, far_far;
};

// The texels of one axis: struct texture_taps.
struct texture_lanes_taps {
    lanes_int near, far;
    lanes_float blend;
};

// texture_wrap_axis()
static inline struct texture_lanes_taps texture_lanes_wrap_axis(const lanes_float u,
                                                                const lanes_int size,
                                                                const lanes_uint wrap,
                                                                const lanes_int nearest)
{
    const lanes_int repeats = wrap == TEXTURE_WRAP_REPEAT;
    lanes_float at = u - lanes_floor(u);
    if (lanes_bits(repeats) != LANES_ALL) {
        const lanes_float mirrored = u - 2.0f * lanes_floor(0.5f * u);
        const lanes_float turned = mirrored > 1.0f ? 2.0f - mirrored : mirrored;
        const lanes_float clamped =
            lanes_min(lanes_max(u, (lanes_float)(0.0f)), (lanes_float)(1.0f));
        at = repeats ? at : wrap == TEXTURE_WRAP_MIRROR ? turned : clamped;
    }

    struct texture_lanes_taps taps;
    const lanes_int last = size - 1;
    const lanes_float x =
        at * lanes_to_float(size) - (nearest ? (lanes_float)(0.0f) : (lanes_float)(0.5f));
    const lanes_float cell = lanes_floor(x);
    const lanes_int near = lanes_to_int(cell);
    const lanes_int far = near + 1;
    taps.blend = nearest ? (lanes_float)(0.0f) : x - cell;
    // Beyond an end is the other one, or the same.
    const lanes_int zero = (lanes_int)(0);
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
    const lanes_uint flags = LANES_WORD(lanes_uint, materials, material, .textures[use].flags);
    const lanes_uint size = LANES_WORD(lanes_uint, materials, material, .textures[use].size);
    const lanes_uint first =
        LANES_WORD(lanes_uint, materials, material, .textures[use].texel_first);
    const struct lanes4 m = LANES_OF(materials, material, .textures[use].uv_matrix);
    const lanes_float move_x =
        LANES_WORD(lanes_float, materials, material, .textures[use].uv_offset.x);
    const lanes_float move_y =
        LANES_WORD(lanes_float, materials, material, .textures[use].uv_offset.y);

    // Find the columns and the rows.
    const lanes_int second = (flags & TEXTURE_UV1) != 0u;
    const lanes_float u = second ? uv.z : uv.x;
    const lanes_float v = second ? uv.w : uv.y;
    const lanes_int nearest = (flags & TEXTURE_NEAREST) != 0u;
    const lanes_uint width = size & 0xffffu;
    const struct texture_lanes_taps x =
        texture_lanes_wrap_axis(m.x * u + m.y * v + move_x, lanes_as_int(width),
                                (flags >> TEXTURE_WRAP_S_SHIFT) & 3u, nearest);
    const struct texture_lanes_taps y =
        texture_lanes_wrap_axis(m.z * u + m.w * v + move_y, lanes_as_int(size >> 16),
                                (flags >> TEXTURE_WRAP_T_SHIFT) & 3u, nearest);

    // Find their places in the pool.
    const lanes_int own = lanes_mask(bits);
    const lanes_uint near_row = first + lanes_as_uint(y.near) * width;
    const lanes_uint far_row = first + lanes_as_uint(y.far) * width;
    const lanes_uint zero = (lanes_uint)(0u);
    lanes_store(own ? near_row + lanes_as_uint(x.near) : zero, out->near_near);
    lanes_store(own ? near_row + lanes_as_uint(x.far) : zero, out->far_near);
    lanes_store(own ? far_row + lanes_as_uint(x.near) : zero, out->near_far);
    lanes_store(own ? far_row + lanes_as_uint(x.far) : zero, out->far_far);
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
        const uint k = bits_lowest(bits);
        PREFETCH(&texels[lanes->near_near[k]]);
        PREFETCH(&texels[lanes->near_far[k]]);
    }
}

#endif

// One channel of texels, decoded; `shift` is the place of its bits.
static inline lanes_float texture_lanes_decode(const lanes_uint texel, const uint shift,
                                               const lanes_int srgb)
{
    const lanes_uint code = (texel >> shift) & 255u;
    const lanes_float linear = lanes_to_float(lanes_as_int(code)) * (1.0f / 255.0f);
    if (lanes_bits(srgb) == 0)
        return linear;
    uint codes[LANES];
    lanes_store(code, codes);
    const lanes_float decoded = LANES_EACH(lanes_float, srgb_decode, codes);
    return srgb ? decoded : linear;
}

// Filters one channel of four texels.
static inline lanes_float texture_lanes_blend(const struct texture_lanes *lanes,
                                              const struct texture_lanes_texels *t,
                                              const uint shift, const lanes_int srgb)
{
    const lanes_float top = mix(texture_lanes_decode(t->near_near, shift, srgb),
                                texture_lanes_decode(t->far_near, shift, srgb), lanes->x);
    const lanes_float bottom = mix(texture_lanes_decode(t->near_far, shift, srgb),
                                   texture_lanes_decode(t->far_far, shift, srgb), lanes->x);
    return mix(top, bottom, lanes->y);
}

// The values of the texels that were found; 1, 1, 1, 1 in lanes without a bit.
static inline struct lanes4 texture_lanes_fetch(const struct texture_lanes *lanes, const uint bits,
                                                __global const uint *texels)
{
    struct texture_lanes_texels t;
    t.near_near = LANES_WORD(lanes_uint, texels, lanes->near_near, );
    t.far_near = LANES_WORD(lanes_uint, texels, lanes->far_near, );
    t.near_far = LANES_WORD(lanes_uint, texels, lanes->near_far, );
    t.far_far = LANES_WORD(lanes_uint, texels, lanes->far_far, );
    const lanes_int own = lanes_mask(bits);
    const lanes_float one = (lanes_float)(1.0f);
    const lanes_float x = texture_lanes_blend(lanes, &t, 0, lanes->srgb);
    const lanes_float y = texture_lanes_blend(lanes, &t, 8, lanes->srgb);
    const lanes_float z = texture_lanes_blend(lanes, &t, 16, lanes->srgb);
    const lanes_float w = texture_lanes_blend(lanes, &t, 24, (lanes_int)(0)); // always linear
    return lanes4_make(lanes3_make(own ? x : one, own ? y : one, own ? z : one), own ? w : one);
}

#endif
