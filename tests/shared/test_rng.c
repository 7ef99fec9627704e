// Random numbers: uniform along every input, in their high and low bits, alone and in pairs.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "shared/rng.h"

#define BINS   256u
#define DRAWS  (1u << 16)
#define SIGMAS 6.0 // of a chi-square's spread, far beyond chance for the 400 sums taken here

// The numbers of a walk along one input, the others held.
static uint4 draw(int input, uint32_t at, const uint32_t *held)
{
    uint32_t v[4];
    memcpy(v, held, sizeof(v));
    v[input] += at;
    return rng_bits(v[0], v[1], v[2], v[3]);
}

static uint32_t component(uint4 v, int k)
{
    return k == 0 ? v.x : k == 1 ? v.y : k == 2 ? v.z : v.w;
}

static void check_chi_square(const uint32_t *counts)
{
    const double expected = (double)DRAWS / BINS;
    double sum = 0.0;
    for (uint32_t i = 0; i < BINS; i++)
        sum += (counts[i] - expected) * (counts[i] - expected) / expected;
    assert_true(fabs(sum - (BINS - 1)) < SIGMAS * sqrt(2.0 * (BINS - 1)));
}

// Starts that renders have: small numbers; and the dimensions of deep bounces.
static const uint32_t starts[][4] = {
    {0, 0, 0, 0},
    {7, 123456, 64, 0x00400000},
    {1, 1919 + 1079 * 1920, 3, 0x05800003},
};

#define START_COUNT (sizeof(starts) / sizeof(starts[0]))

static void numbers_are_uniform_along_every_input(void **state)
{
    (void)state;
    for (size_t start = 0; start < START_COUNT; start++) {
        for (int input = 0; input < 4; input++) {
            for (int k = 0; k < 4; k++) {
                uint32_t high[BINS] = {0};
                uint32_t middle[BINS] = {0}; // the last bits that rng_unit() keeps
                for (uint32_t i = 0; i < DRAWS; i++) {
                    const uint32_t bits = component(draw(input, i, starts[start]), k);
                    high[bits >> 24]++;
                    middle[bits >> 8 & 255u]++;
                }
                check_chi_square(high);
                check_chi_square(middle);
            }
        }
    }
}

// The four numbers of a block, and a number and its neighbour's: 16 x 16 squares.
static void pairs_are_uniform(void **state)
{
    (void)state;
    for (size_t start = 0; start < START_COUNT; start++) {
        for (int input = 0; input < 4; input++) {
            for (int k = 0; k < 4; k++) {
                uint32_t block[BINS] = {0};
                uint32_t neighbour[BINS] = {0};
                for (uint32_t i = 0; i < DRAWS; i++) {
                    const uint4 bits = draw(input, i, starts[start]);
                    const uint4 next = draw(input, i + 1, starts[start]);
                    const uint32_t first = component(bits, k) >> 28 << 4;
                    block[first | component(bits, (k + 1) % 4) >> 28]++;
                    neighbour[first | component(next, k) >> 28]++;
                }
                check_chi_square(block);
                check_chi_square(neighbour);
            }
        }
    }
}

static void units_are_below_one_and_exact(void **state)
{
    (void)state;
    assert_true(rng_unit(0) == 0.0f);
    assert_true(rng_unit(UINT32_MAX) < 1.0f);
    for (uint32_t i = 0; i < 1u << 24; i += 4099)
        assert_true(rng_unit(i << 8 | 255u) * 0x1p24f == (float)i);
}

static void dimensions_are_distinct(void **state)
{
    (void)state;
    static const uint32_t indices[] = {0, 1, 2, 1000, 0x1fffff};
    uint32_t seen[4 * RNG_USE_COUNT * 5];
    size_t count = 0;
    for (uint32_t depth = 0; depth < 256; depth += 85)
        for (uint32_t use = RNG_USE_CAMERA; use < RNG_USE_COUNT; use++)
            for (size_t i = 0; i < 5; i++)
                seen[count++] = rng_dimension(depth, use, indices[i]);
    for (size_t i = 0; i < count; i++)
        for (size_t j = 0; j < i; j++)
            assert_int_not_equal(seen[i], seen[j]);
}

// Every block but the camera's, of which there is one, has a place of its own.
static void blocks_have_places_of_their_own(void **state)
{
    (void)state;
    uint8_t seen[1 + 255 * (RNG_USE_COUNT - 1)] = {0};
    assert_int_equal(sizeof(seen), rng_block_count(255));
    seen[rng_block(0, RNG_USE_CAMERA)]++;
    for (uint32_t depth = 0; depth < 255; depth++)
        for (uint32_t use = RNG_USE_BSDF; use < RNG_USE_COUNT; use++) {
            assert_true(rng_block(depth, use) < rng_block_count(depth + 1));
            seen[rng_block(depth, use)]++;
        }
    for (size_t i = 0; i < sizeof(seen); i++)
        assert_int_equal(seen[i], 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(numbers_are_uniform_along_every_input),
        cmocka_unit_test(pairs_are_uniform),
        cmocka_unit_test(units_are_below_one_and_exact),
        cmocka_unit_test(dimensions_are_distinct),
        cmocka_unit_test(blocks_have_places_of_their_own),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
