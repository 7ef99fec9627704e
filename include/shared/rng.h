/**
 * @file
 * Random numbers as a pure function of (seed, pixel, sample, dimension): no state, so any order of
 * work gives the same bits.
 *
 * Source: M. Jarzynski, M. Olano, "Hash Functions for GPU Rendering", JCGT 9(3), 2020: pcg4d. One
 * call gives four numbers, one block of a path's dimensions.
 */
#ifndef SHARED_RNG_H
#define SHARED_RNG_H

#include "shared/base.h"

// What a block of four numbers is drawn for.
enum rng_use {
    RNG_USE_CAMERA = 0, // x, y: place in the pixel
    RNG_USE_BSDF = 1,   // x: lobe; y, z: direction; w: Russian roulette
    RNG_USE_LIGHT = 2,  // x: which light; y, z: place on it
};

// The index, among those of RNG_USE_LIGHT, that draws from the environment: past the last light.
#define RNG_ENVIRONMENT 0x3fffffu

// Names one block: 8 bits of depth, 2 of use, 22 of index (the number of the shadow ray).
static inline uint rng_dimension(uint depth, uint use, uint index)
{
    return (depth << 24) | (use << 22) | (index & 0x3fffffu);
}

// Four uniform 32-bit numbers for one block of one sample of one pixel (its place in Z-order).
static inline uint4 rng_bits(uint seed, uint pixel, uint sample, uint dimension)
{
    uint4 v;
    v.x = pixel * 1664525u + 1013904223u;
    v.y = sample * 1664525u + 1013904223u;
    v.z = dimension * 1664525u + 1013904223u;
    v.w = seed * 1664525u + 1013904223u;

    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;

    v.x ^= v.x >> 16;
    v.y ^= v.y >> 16;
    v.z ^= v.z >> 16;
    v.w ^= v.w >> 16;

    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
    return v;
}

// Mixes 32 bits into others (M. O'Neill's PCG output function, as in Jarzynski and Olano's pcg).
static inline uint rng_mix(uint v)
{
    const uint state = v * 747796405u + 2891336453u;
    const uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// Maps 32 random bits to [0, 1): the upper 24, so that the result is exact and never 1.
static inline float rng_unit(uint bits)
{
    return (float)(bits >> 8) * (1.0f / 16777216.0f);
}

#endif
