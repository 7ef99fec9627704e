// The pure functions of include/shared/, on the device.

#include "shared/oct.h"
#include "shared/rng.h"
#include "shared/zorder.h"
#include "test.h"

TEST_KERNEL parity_rng(__global const uint4 *in, __global uint4 *bits, __global float *units,
                       __global uint *dimensions, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    const uint4 v = in[i];
    bits[i] = rng_bits(v.x, v.y, v.z, v.w);
    units[i] = rng_unit(v.x);
    dimensions[i] = rng_dimension(v.x & 255u, v.y & 7u, v.z);
}

// in: index, width, height.
TEST_KERNEL parity_zorder(__global const uint4 *in, __global uint *pixels, const uint count)
{
    const uint i = get_global_id(0);
    if (i < count)
        pixels[i] = zorder_pixel(in[i].x, in[i].y, in[i].z);
}

TEST_KERNEL parity_oct(__global const float4 *normals, __global const uint *words,
                       __global uint *packed, __global float4 *unpacked, const uint count)
{
    const uint i = get_global_id(0);
    if (i >= count)
        return;
    packed[i] = oct_pack(normals[i].x, normals[i].y, normals[i].z);
    unpacked[i] = oct_unpack(words[i]);
}
