/**
 * @file
 * Four planes of boxes out of the bytes of a word (shared/byte_planes.h).
 */
#ifndef LIB_BYTE_PLANES_H
#define LIB_BYTE_PLANES_H

#include "lib/warp.h"
#include "shared/byte_planes.h"

#define BYTE_PLANES_ONE 0x3f800000u // bits of 1

// The planes as 1 + byte * 2^-BYTE_PLANE_SHIFT.
static inline float4 byte_planes(const uint bytes)
{
#if WARP_VOTES
    return (float4)(warp_pick(bytes, BYTE_PLANES_ONE, 0x7604u),
                    warp_pick(bytes, BYTE_PLANES_ONE, 0x7614u),
                    warp_pick(bytes, BYTE_PLANES_ONE, 0x7624u),
                    warp_pick(bytes, BYTE_PLANES_ONE, 0x7634u));
#else
    const uint4 shifted = (uint4)(bytes << 8, bytes, bytes >> 8, bytes >> 16);
    return as_float4((shifted & 0xff00u) | BYTE_PLANES_ONE);
#endif
}

// The same by other units of an NVIDIA GPU, which are idle while those of byte_planes() are busy:
// half of a node's planes each way.
static inline float4 byte_planes_too(const uint bytes)
{
#if WARP_VOTES
    return warp_pick_four(bytes, BYTE_PLANES_ONE);
#else
    return byte_planes(bytes);
#endif
}

#endif
