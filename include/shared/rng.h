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
    RNG_USE_CAMERA = 0,      // y, z: place in the pixel
    RNG_USE_BSDF = 1,        // x: lobe; y, z: direction; w: Russian roulette
    RNG_USE_LIGHT = 2,       // x: which light; y, z: place on it
    RNG_USE_ENVIRONMENT = 3, // x, w: which texel; y, z: place in it
    RNG_USE_LAYER = 4,       // x: which layer
    RNG_USE_COUNT = 5
};

#define RNG_INDEX_MASK  0x1fffffu
#define RNG_DEPTH_SHIFT 24

// Names one block: 8 bits of depth, 3 of use, 21 of index (where every light is drawn, which).
static inline uint rng_dimension(uint depth, uint use, uint index)
{
    return (depth << RNG_DEPTH_SHIFT) | (use << 21) | (index & RNG_INDEX_MASK);
}

// The block's place in the table of points (lib/samples.h): those of one index share it.
static inline uint rng_block(uint depth, uint use)
{
    return use == RNG_USE_CAMERA ? 0 : depth * (RNG_USE_COUNT - 1) + use;
}

// Blocks of paths of this many shaded hits.
static inline uint rng_block_count(uint depth)
{
    return 1 + depth * (RNG_USE_COUNT - 1);
}

// pcg4d, in place: v has four unsigned numbers x, y, z, w of 32 bits, or four vectors of them.
#define RNG_SCRAMBLE(v)                                                                            \
    do {                                                                                           \
        (v).x = (v).x * 1664525u + 1013904223u;                                                    \
        (v).y = (v).y * 1664525u + 1013904223u;                                                    \
        (v).z = (v).z * 1664525u + 1013904223u;                                                    \
        (v).w = (v).w * 1664525u + 1013904223u;                                                    \
        (v).x += (v).y * (v).w;                                                                    \
        (v).y += (v).z * (v).x;                                                                    \
        (v).z += (v).x * (v).y;                                                                    \
        (v).w += (v).y * (v).z;                                                                    \
        (v).x ^= (v).x >> 16;                                                                      \
        (v).y ^= (v).y >> 16;                                                                      \
        (v).z ^= (v).z >> 16;                                                                      \
        (v).w ^= (v).w >> 16;                                                                      \
        (v).x += (v).y * (v).w;                                                                    \
        (v).y += (v).z * (v).x;                                                                    \
        (v).z += (v).x * (v).y;                                                                    \
        (v).w += (v).y * (v).z;                                                                    \
    } while (0)

// Four uniform 32-bit numbers for one block of one sample of one pixel (its place in Z-order).
static inline uint4 rng_bits(uint seed, uint pixel, uint sample, uint dimension)
{
    uint4 v;
    v.x = pixel;
    v.y = sample;
    v.z = dimension;
    v.w = seed;
    RNG_SCRAMBLE(v);
    return v;
}

// Mixes 32 bits into others (M. O'Neill's PCG output function, as in Jarzynski and Olano's pcg).
static inline uint rng_mix(uint v)
{
    const uint state = v * 747796405u + 2891336453u;
    const uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

// The largest number of rng_unit(), and what lies between two.
#define RNG_UNIT_MAX  0.99999994f
#define RNG_UNIT_STEP (1.0f / 16777216.0f)

// Maps 32 random bits to [0, 1): the upper 24, so that the result is exact and never 1.
static inline float rng_unit(uint bits)
{
    return (float)(bits >> 8) * RNG_UNIT_STEP;
}

#endif
