/**
 * @file
 * What the lanes of an NVIDIA warp tell each other, by inline PTX: OpenCL C has no words for it.
 * Used where a trial compile shows that the device's compiler takes it (device/program.h).
 */
#ifndef LIB_WARP_H
#define LIB_WARP_H

#include "shared/base.h"

#if WARP_VOTES

#define WARP_LANES 32

// The lanes that are here now, a bit each.
static inline uint warp_here(void)
{
    uint here;
    __asm volatile("activemask.b32 %0;" : "=r"(here));
    return here;
}

// How many lanes are here now.
static inline uint warp_lanes(void)
{
    return popcount(warp_here());
}

// For how many of the lanes that are here now something holds.
static inline uint warp_count(const bool holds)
{
    const uint here = warp_here();
    uint which;
    __asm volatile("{ .reg .pred p; setp.ne.u32 p, %1, 0; vote.sync.ballot.b32 %0, p, %2; }"
                   : "=r"(which)
                   : "r"((uint)holds), "r"(here));
    return popcount(which);
}

// A float made of four bytes of two words, by the digits of `which` from the lowest on: 0 .. 3 are
// those of a, 4 .. 7 those of b.
static inline float warp_pick(const uint a, const uint b, const uint which)
{
    uint picked;
    __asm("prmt.b32 %0, %1, %2, %3;" : "=r"(picked) : "r"(a), "r"(b), "r"(which));
    return as_float(picked);
}

// a * b + c, or the nearest of 0 .. 1 to it, by one instruction; 0 if it is no number.
static inline float warp_muladd_unit(const float a, const float b, const float c)
{
    float sum;
    __asm("fma.rn.ftz.sat.f32 %0, %1, %2, %3;" : "=f"(sum) : "f"(a), "f"(b), "f"(c));
    return sum;
}

// The same of a - b.
static inline float warp_sub_unit(const float a, const float b)
{
    float difference;
    __asm("sub.ftz.sat.f32 %0, %1, %2;" : "=f"(difference) : "f"(a), "f"(b));
    return difference;
}

// A float made of `rest` and of one of the two lower bytes, put where `rest` is 0 below: the lowest
// by the factor 2^k, the other by 2^(16 + k), which shift it left by k. What warp_pick() makes, but
// by products, which units for sums do while those for bits are busy.
static inline float warp_pick_low(const uint bytes, const uint rest, const uint factor)
{
    uint sum;
    __asm("dp2a.lo.u32.u32 %0, %1, %2, %3;" : "=r"(sum) : "r"(factor), "r"(bytes), "r"(rest));
    return as_float(sum);
}

// The same of the two upper bytes.
static inline float warp_pick_high(const uint bytes, const uint rest, const uint factor)
{
    uint sum;
    __asm("dp2a.hi.u32.u32 %0, %1, %2, %3;" : "=r"(sum) : "r"(factor), "r"(bytes), "r"(rest));
    return as_float(sum);
}

// Loads three rows at once. A compiler loads each where it is first needed, and a warp some of
// whose lanes have come through the test of one row waits for the next.
static inline void warp_load_rows(float4 *a, float4 *b, float4 *c, __global const float4 *from)
{
    float4 x, y, z;
    __asm volatile("ld.global.nc.v4.f32 {%0, %1, %2, %3}, [%12];\n\t"
                   "ld.global.nc.v4.f32 {%4, %5, %6, %7}, [%12 + 16];\n\t"
                   "ld.global.nc.v4.f32 {%8, %9, %10, %11}, [%12 + 32];"
                   : "=f"(x.x), "=f"(x.y), "=f"(x.z), "=f"(x.w), "=f"(y.x), "=f"(y.y), "=f"(y.z),
                     "=f"(y.w), "=f"(z.x), "=f"(z.y), "=f"(z.z), "=f"(z.w)
                   : "l"((ulong)from));
    *a = x;
    *b = y;
    *c = z;
}

// Fetches a place of a queue for each of the lanes that are here, by one atomic add.
static inline uint warp_fetch(volatile __global uint *head)
{
    const uint here = warp_here();
    const uint before = here & ((1u << (uint)get_local_id(0) % WARP_LANES) - 1u);
    const uint leader = 31u - clz(here & (0u - here));
    uint first = 0;
    if (before == 0)
        first = atomic_add(head, popcount(here));
    uint place;
    __asm volatile("shfl.sync.idx.b32 %0, %1, %2, 31, %3;"
                   : "=r"(place)
                   : "r"(first), "r"(leader), "r"(here));
    return place + popcount(before);
}

// The first lane's value. All lanes of the warp must come here.
static inline uint warp_first(const uint value)
{
    uint first;
    __asm volatile("shfl.sync.idx.b32 %0, %1, 0, 31, 0xffffffff;" : "=r"(first) : "r"(value));
    return first;
}

#endif

#endif
