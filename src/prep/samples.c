#include "prep/samples.h"

#include "prep/array.h"
#include "shared/rng.h"

#define DIMENSIONS 4 // of a block

// Direction numbers of the four dimensions: column `bit` of the generator matrix, highest bit
// first.
struct generators {
    uint column[DIMENSIONS][32];
};

// Fills the columns of one dimension from a primitive polynomial over GF(2) of this degree, less
// its first and last coefficients, and its initial numbers (Joe and Kuo 2008, section 2).
static void fill_columns(uint *column, uint degree, uint coefficients, const uint *initial)
{
    for (uint i = 0; i < degree; i++)
        column[i] = initial[i] << (31 - i);
    for (uint i = degree; i < 32; i++) {
        column[i] = column[i - degree] ^ column[i - degree] >> degree;
        for (uint k = 1; k < degree; k++)
            if (coefficients >> (degree - 1 - k) & 1u)
                column[i] ^= column[i - k];
    }
}

// The pairs (y, z) and (x, w) of a block: the first two dimensions, whose every pair of intervals
// is met evenly, go to y and z, which are the places on surfaces and of directions.
static struct generators make_generators(void)
{
    struct generators out;
    for (uint i = 0; i < 32; i++)
        out.column[1][i] = 1u << (31 - i); // van der Corput
    fill_columns(out.column[2], 1, 0, (const uint[]){1});
    fill_columns(out.column[0], 2, 1, (const uint[]){1, 3});
    fill_columns(out.column[3], 3, 1, (const uint[]){1, 3, 1});
    return out;
}

static uint multiply(const uint *column, uint number)
{
    uint out = 0;
    for (uint i = 0; number != 0; i++, number >>= 1)
        if (number & 1u)
            out ^= column[i];
    return out;
}

// Owen's nested scrambling of the highest `levels` bits: whether a bit is turned over depends on
// those above it. The bits below are one random number of the interval's.
static uint scramble(uint x, uint levels, uint key)
{
    uint out = 0;
    for (uint level = 0; level < levels; level++) {
        const uint above = level > 0 ? x >> (32 - level) : 0;
        const uint turn = rng_mix(key ^ rng_mix(above | 1u << level));
        out |= (x ^ turn) & 0x80000000u >> level;
    }
    const uint interval = levels > 0 ? x >> (32 - levels) : 0;
    return out | (rng_mix(~key ^ rng_mix(interval)) & 0xffffffffu >> levels);
}

// Fills the points of one block.
static void fill_block(uint4 *out, const struct generators *generators, uint seed, uint block,
                       uint shift)
{
    const uint count = 1u << shift;
    const uint4 keys = rng_bits(seed, block, 0, 0);
    const uint order = rng_bits(seed, block, 1, 0).x;
    for (uint i = 0; i < count; i++) {
        // The shuffle keeps every aligned run of a power of two together.
        const uint number = scramble(i << (32 - shift), shift, order) >> (32 - shift);
        out[i].x = scramble(multiply(generators->column[0], number), shift, keys.x);
        out[i].y = scramble(multiply(generators->column[1], number), shift, keys.y);
        out[i].z = scramble(multiply(generators->column[2], number), shift, keys.z);
        out[i].w = scramble(multiply(generators->column[3], number), shift, keys.w);
    }
}

enum status samples_build(uint4 **out, uint seed, uint depth, uint shift)
{
    const uint blocks = rng_block_count(depth);
    uint4 *points = array_alloc((size_t)blocks << shift, sizeof(*points));
    if (points == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u blocks of %u samples", blocks,
                           1u << shift);
    const struct generators generators = make_generators();
    for (uint block = 0; block < blocks && shift == 0; block++)
        points[block] = (uint4){0, 0, 0, 0};
    if (shift > 0) {
#pragma omp parallel for schedule(static)
        for (uint block = 0; block < blocks; block++)
            fill_block(points + ((size_t)block << shift), &generators, seed, block, shift);
    }
    *out = points;
    return STATUS_OK;
}
