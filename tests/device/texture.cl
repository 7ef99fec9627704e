// lib/texture.h and its twin for eight hits: the pool and a bound image, asked the same.

#define TEXTURE_IMAGES 1

#include "lib/texture.h"
#include "lib/texture_lanes.h"
#include "test.h"

TEST_KERNEL texture_from_pool(__global const uint *restrict texels,
                              __global const struct texture_slot *slot, __global const float4 *uvs,
                              const uint count, __global float4 *out)
{
    const uint i = get_global_id(0);
    if (i < count)
        out[i] = texture_fetch_pool(texels, slot, uvs[i]);
}

// As texture_from_pool(), side by side; count is a multiple. Alpha is not looked up so.
TEST_KERNEL texture_from_lanes(__global const uint *restrict texels,
                               __global const struct material *material, __global const float4 *uvs,
                               const uint count, __global float4 *out)
{
    const uint first = get_global_id(0) * LANES;
    if (first >= count)
        return;
    const uint every =
        (first / LANES) % 2 == 0 ? LANES_ALL : (0x5a5au & LANES_ALL); // others are to be white
    const uint materials[LANES] = {0};
    uint places[LANES];
    lanes_store(first + lanes_as_uint(LANES_ORDER), places);
    struct texture_lanes lanes;
    texture_lanes_find(&lanes, material, materials, TEXTURE_BASE, every, LANES_OF(uvs, places, ));
    LANES_STORE(out, places, , LANES_ALL, texture_lanes_fetch(&lanes, every, texels));
    for (uint i = first; i < first + LANES; i++) {
        const float4 single = texture_fetch_pool(texels, &material->textures[TEXTURE_BASE], uvs[i]);
        const bool is_white = all(out[i] == 1.0f);
        if (!(every & (1u << (i - first))))
            out[i] = is_white ? single : (float4)(-1.0f);
    }
}

TEST_KERNEL texture_from_image(__read_only image2d_t image,
                               __global const struct texture_slot *slot, __global const float4 *uvs,
                               const uint count, __global float4 *out)
{
    const uint i = get_global_id(0);
    if (i < count)
        out[i] = texture_fetch(image, slot, uvs[i]);
}

// out: sRGB decoded and plain, of each texel.
TEST_KERNEL texture_decoded(__global const uint *texels, const uint count, __global float4 *out)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    out[2 * i] = texture_decode(texels[i], true);
    out[2 * i + 1] = texture_decode(texels[i], false);
}
