/**
 * @file
 * Unit vectors in 32 bits: octahedral, two signed 16-bit coordinates.
 *
 * Source: Z. Cigolle et al., "A Survey of Efficient Representations for Independent Unit Vectors",
 * JCGT 3(2), 2014, section 3: oct32. Differs from it: plain rounding, not the precise search; the
 * largest error is 0.0037 degrees.
 */
#ifndef SHARED_OCT_H
#define SHARED_OCT_H

#include "shared/base.h"

static inline float oct_abs(float x)
{
    return x < 0.0f ? -x : x;
}

static inline uint oct_round(float x)
{
    const float scaled = x * 32767.0f;
    return (uint)(int)(scaled < 0.0f ? scaled - 0.5f : scaled + 0.5f) & 0xffffu;
}

// Packs a unit vector.
static inline uint oct_pack(float x, float y, float z)
{
    const float scale = 1.0f / (oct_abs(x) + oct_abs(y) + oct_abs(z));
    float u = x * scale;
    float v = y * scale;
    if (z < 0.0f) {
        const float folded = (1.0f - oct_abs(v)) * (u < 0.0f ? -1.0f : 1.0f);
        v = (1.0f - oct_abs(u)) * (v < 0.0f ? -1.0f : 1.0f);
        u = folded;
    }
    return oct_round(u) | (oct_round(v) << 16);
}

// Unpacks to a vector that has yet to be normalised; w is 0.
static inline float4 oct_unpack(uint packed)
{
    float4 n;
    n.x = (float)(int)(short)(packed & 0xffffu) * (1.0f / 32767.0f);
    n.y = (float)(int)(short)(packed >> 16) * (1.0f / 32767.0f);
    n.z = 1.0f - oct_abs(n.x) - oct_abs(n.y);
    n.w = 0.0f;
    if (n.z < 0.0f) {
        const float x = n.x;
        n.x = (1.0f - oct_abs(n.y)) * (x < 0.0f ? -1.0f : 1.0f);
        n.y = (1.0f - oct_abs(x)) * (n.y < 0.0f ? -1.0f : 1.0f);
    }
    return n;
}

// The lowest bit of v gives way to a flag; the error stays below 0.006 degrees.
#define OCT_FLAG 0x10000u

// Packs a unit tangent, and whether the bitangent runs against cross(normal, tangent).
static inline uint tangent_pack(float x, float y, float z, uint against)
{
    return (oct_pack(x, y, z) & ~OCT_FLAG) | (against != 0 ? OCT_FLAG : 0u);
}

#endif
