/**
 * @file
 * Small mathematics for kernels: vectors, frames, sampling of simple shapes.
 */
#ifndef LIB_MATH_H
#define LIB_MATH_H

#include "shared/base.h"

#define PI     3.14159265358979f
#define INV_PI 0.318309886183791f

// The multiply-add that is fast here; both round less than two operations. PoCL's mad() is two, and
// its fma() one where the CPU has it, though it does not say so.
#if defined(FP_FAST_FMAF) || defined(__FMA__)
#define MULADD(a, b, c) fma(a, b, c)
#else
#define MULADD(a, b, c) mad(a, b, c)
#endif

// The smaller and the larger of two numbers that are none of them NaN. GPUs have an instruction for
// what fmin and fmax ask; on CPUs they take several for the sake of NaN, a third of a traversal.
#if DEVICE_CPU

static inline float min2(const float a, const float b)
{
    return a < b ? a : b;
}

static inline float max2(const float a, const float b)
{
    return a > b ? a : b;
}

#else

static inline float min2(const float a, const float b)
{
    return fmin(a, b);
}

static inline float max2(const float a, const float b)
{
    return fmax(a, b);
}

#endif

static inline float max3(const float3 v)
{
    return max2(max2(v.x, v.y), v.z);
}

// Luminance of linear Rec. 709.
static inline float luminance(const float3 v)
{
    return 0.2126f * v.x + 0.7152f * v.y + 0.0722f * v.z;
}

// (cos, sin) of 2 pi u for 0 <= u <= 1, to 4e-7: Taylor on an eighth of the circle either way. The
// built-ins are exact over all floats, which takes PoCL five times as long.
static inline float2 cos_sin_turn(const float u)
{
    const int quarter = (int)(4.0f * u + 0.5f);
    const float a = (4.0f * u - (float)quarter) * (0.5f * PI);
    const float a2 = a * a;
    const float s = a * (1.0f + a2 * (-1.0f / 6.0f + a2 * (1.0f / 120.0f - a2 * (1.0f / 5040.0f))));
    const float c =
        1.0f + a2 * (-0.5f + a2 * (1.0f / 24.0f + a2 * (-1.0f / 720.0f + a2 * (1.0f / 40320.0f))));
    const float x = (quarter & 1) ? s : c;
    const float y = (quarter & 1) ? c : s;
    const int q = quarter & 3;
    return (float2)((q == 1 || q == 2) ? -x : x, (q >= 2) ? -y : y);
}

// Two unit vectors that make a right-handed frame with the unit vector n (T. Duff et al., "Building
// an Orthonormal Basis, Revisited", JCGT 6(1), 2017).
static inline void frame_build(float3 *tangent, float3 *bitangent, const float3 n)
{
    const float sign = n.z < 0.0f ? -1.0f : 1.0f;
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    *tangent = (float3)(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    *bitangent = (float3)(b, sign + n.y * n.y * a, -n.y);
}

// A direction about n with density cos / pi.
static inline float3 sample_cosine(const float3 n, const float u0, const float u1)
{
    const float r = sqrt(u0);
    const float2 turn = cos_sin_turn(u1);
    float3 tangent, bitangent;
    frame_build(&tangent, &bitangent, n);
    return normalize(r * turn.x * tangent + r * turn.y * bitangent + sqrt(1.0f - u0) * n);
}

// Weight of one strategy's sample against another's: the power heuristic with exponent 2 (E. Veach,
// thesis, 1997, section 9.2.2).
static inline float mis_weight(const float mine, const float other)
{
    // The ratio first: squares of densities pass the range of float.
    const float ratio = other / mine;
    return 1.0f / (1.0f + ratio * ratio);
}

#endif
