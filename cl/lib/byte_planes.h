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
    return (float4)(warp_pick_low(bytes, BYTE_PLANES_ONE, 0x100u),
                    warp_pick_low(bytes, BYTE_PLANES_ONE, 0x1000000u),
                    warp_pick_high(bytes, BYTE_PLANES_ONE, 0x100u),
                    warp_pick_high(bytes, BYTE_PLANES_ONE, 0x1000000u));
#else
    return byte_planes(bytes);
#endif
}

// Which bytes of two words, each lo and hi of one box and lo and hi of the next, are the planes
// that a ray meets first.
struct byte_pick {
#if WARP_VOTES
    uint near0, near1; // digits of warp_pick() for either box
    uint far;          // factor of warp_pick_low() and warp_pick_high()
#else
    uint near, far; // bits to shift
#endif
};

//   back  the ray meets hi first
static inline struct byte_pick byte_pick(const bool back)
{
    struct byte_pick pick;
#if WARP_VOTES
    pick.near0 = back ? 0x7614u : 0x7604u;
    pick.near1 = back ? 0x7634u : 0x7624u;
    pick.far = back ? 0x100u : 0x1000000u;
#else
    pick.near = back ? 8 : 0;
    pick.far = back ? 0 : 8;
#endif
    return pick;
}

#if !WARP_VOTES

// Of four boxes the planes whose bytes stand `shift` bits up, as byte_planes().
static inline float4 byte_planes_at(const uint2 bytes, const uint shift)
{
    const uint4 shifted = (uint4)(bytes.x, bytes.x >> 16, bytes.y, bytes.y >> 16) >> shift;
    return as_float4((shifted << 8 & 0xff00u) | BYTE_PLANES_ONE);
}

#endif

// The planes of four boxes that a ray meets first, as byte_planes().
static inline float4 byte_planes_near(const uint2 bytes, const struct byte_pick pick)
{
#if WARP_VOTES
    return (float4)(warp_pick(bytes.x, BYTE_PLANES_ONE, pick.near0),
                    warp_pick(bytes.x, BYTE_PLANES_ONE, pick.near1),
                    warp_pick(bytes.y, BYTE_PLANES_ONE, pick.near0),
                    warp_pick(bytes.y, BYTE_PLANES_ONE, pick.near1));
#else
    return byte_planes_at(bytes, pick.near);
#endif
}

// Those that it meets last, by the units of byte_planes_too().
static inline float4 byte_planes_far(const uint2 bytes, const struct byte_pick pick)
{
#if WARP_VOTES
    return (float4)(warp_pick_low(bytes.x, BYTE_PLANES_ONE, pick.far),
                    warp_pick_high(bytes.x, BYTE_PLANES_ONE, pick.far),
                    warp_pick_low(bytes.y, BYTE_PLANES_ONE, pick.far),
                    warp_pick_high(bytes.y, BYTE_PLANES_ONE, pick.far));
#else
    return byte_planes_at(bytes, pick.far);
#endif
}

#endif
