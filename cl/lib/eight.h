/**
 * @file
 * What CPUs do with eight or sixteen numbers at once, and OpenCL C has no word for.
 */
#ifndef LIB_EIGHT_H
#define LIB_EIGHT_H

#include "shared/base.h"

#ifndef WIDE_PORTABLE
#define WIDE_PORTABLE 0 // 1: without x86's own instructions, as on other CPUs
#endif

// What is to be where it is called: LLVM leaves long functions apart that are called more than
// once, and then vectors go through memory, and constants that parameters are become variables.
#define INLINED static inline __attribute__((always_inline))

// Plain comparisons: fmin and fmax would carry NaNs.
static inline float8 min8(const float8 a, const float8 b)
{
    return a < b ? a : b;
}

static inline float8 max8(const float8 a, const float8 b)
{
    return a > b ? a : b;
}

static inline float16 min16(const float16 a, const float16 b)
{
    return a < b ? a : b;
}

static inline float16 max16(const float16 a, const float16 b)
{
    return a > b ? a : b;
}

// Bit k is set where lane k is true.
static inline uint bits8(const int8 lanes)
{
#if !WIDE_PORTABLE && defined(__AVX__)
    return (uint)__builtin_ia32_movmskps256(as_float8(lanes));
#else
    const int8 bits = lanes & (int8)(1, 2, 4, 8, 16, 32, 64, 128);
    const int4 four = bits.lo | bits.hi;
    const int2 two = four.lo | four.hi;
    return (uint)(two.x | two.y);
#endif
}

// Bit k is set where lane k is true.
static inline uint bits16(const int16 lanes)
{
#if !WIDE_PORTABLE && defined(__AVX512DQ__)
    return (uint)(ushort)__builtin_ia32_cvtd2mask512(lanes);
#else
    return bits8(lanes.lo) | bits8(lanes.hi) << 8;
#endif
}

// The lowest bit that is set; some is.
static inline uint bits_lowest(const uint bits)
{
#if !WIDE_PORTABLE && defined(__clang__)
    return (uint)__builtin_ctz(bits);
#else
    return 31u - clz(bits & (0u - bits));
#endif
}

// The same numbers, put together before anything is made of them. LLVM 15 makes of shuffles of
// shuffles of loads twice as many loads and half as many shuffles again.
static inline float8 whole8(float8 lanes)
{
#if !WIDE_PORTABLE && defined(__AVX__) && defined(__clang__)
    __asm__("" : "+x"(lanes));
#endif
    return lanes;
}

static inline float16 whole16(float16 lanes)
{
#if !WIDE_PORTABLE && defined(__AVX512F__) && defined(__clang__)
    __asm__("" : "+v"(lanes));
#endif
    return lanes;
}

// 1 / sqrt(x), to two ulps: 14 bits by the instruction for it and one step of Newton's. Of 0 it may
// be no number.
#if !WIDE_PORTABLE && defined(__AVX512VL__) && defined(__clang__)
#define RSQRT_STEP(x, y) ((y) * (1.5f - 0.5f * (x) * (y) * (y)))

static inline float8 rsqrt8(const float8 x)
{
    const float8 y = __builtin_ia32_rsqrt14ps256_mask(x, x, (uchar)0xff);
    return RSQRT_STEP(x, y);
}

static inline float16 rsqrt16(const float16 x)
{
    const float16 y = __builtin_ia32_rsqrt14ps512_mask(x, x, (ushort)0xffff);
    return RSQRT_STEP(x, y);
}
#else
static inline float8 rsqrt8(const float8 x)
{
    return 1.0f / sqrt(x);
}

static inline float16 rsqrt16(const float16 x)
{
    return 1.0f / sqrt(x);
}
#endif

#endif
