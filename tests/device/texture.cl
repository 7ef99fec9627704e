// lib/texture.h: the pool and a bound image, asked the same.

#define TEXTURE_IMAGES 1

#include "lib/texture.h"
#include "test.h"

TEST_KERNEL texture_from_pool(__global const uint *restrict texels,
                              __global const struct texture_slot *slot, __global const float4 *uvs,
                              const uint count, __global float4 *out)
{
    const uint i = get_global_id(0);
    if (i < count)
        out[i] = texture_fetch_pool(texels, slot, uvs[i]);
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
