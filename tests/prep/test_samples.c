// The points of samples: even along each dimension and in pairs, and not alike from block to block.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "prep/samples.h"
#include "shared/rng.h"

#define SHIFT  10u
#define COUNT  (1u << SHIFT)
#define DEPTH  5u
#define CELLS  16u // of a grid over two dimensions, along either
#define SIGMAS 6.0

static uint4 *make_points(uint32_t seed)
{
    uint4 *points = NULL;
    assert_int_equal(samples_build(&points, seed, DEPTH, SHIFT), 0);
    return points;
}

static uint32_t component(uint4 v, uint32_t k)
{
    return k == 0 ? v.x : k == 1 ? v.y : k == 2 ? v.z : v.w;
}

// Every aligned run of 2^level points has one in each of as many equal boxes, `split` halvings
// along one dimension, the rest along the other.
static void check_boxes(const uint4 *block, uint4 turn, uint32_t a, uint32_t b, uint32_t level,
                        uint32_t split)
{
    uint8_t seen[COUNT];
    const uint32_t size = 1u << level;
    for (uint32_t first = 0; first < COUNT; first += size) {
        for (uint32_t i = 0; i < size; i++)
            seen[i] = 0;
        for (uint32_t i = first; i < first + size; i++) {
            const uint64_t x = component(block[i], a) ^ component(turn, a);
            const uint64_t y = component(block[i], b) ^ component(turn, b);
            const uint64_t column = x >> (32 - split);
            const uint64_t row = y >> (32 - (level - split));
            seen[row << split | column]++;
        }
        for (uint32_t i = 0; i < size; i++)
            assert_int_equal(seen[i], 1);
    }
}

static void every_dimension_is_even(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 3; seed++) {
        uint4 *points = make_points(seed);
        for (uint32_t block = 0; block < rng_block_count(DEPTH); block++) {
            const uint4 turn = rng_bits(seed, block, 7, 7); // whatever the shift
            for (uint32_t k = 0; k < 4; k++)
                for (uint32_t level = 0; level <= SHIFT; level++)
                    check_boxes(points + block * COUNT, turn, k, k, level, level);
        }
        free(points);
    }
}

static void y_and_z_are_even_in_all_boxes(void **state)
{
    (void)state;
    for (uint32_t seed = 0; seed < 3; seed++) {
        uint4 *points = make_points(seed);
        for (uint32_t block = 0; block < rng_block_count(DEPTH); block++) {
            const uint4 turn = rng_bits(seed, block, 7, 7);
            for (uint32_t level = 0; level <= SHIFT; level++)
                for (uint32_t split = 0; split <= level; split++)
                    check_boxes(points + block * COUNT, turn, 1, 2, level, split);
        }
        free(points);
    }
}

// Chi-square of the points of each cell of a grid over two dimensions, per degree of freedom.
static double spread(const uint32_t *x, const uint32_t *y)
{
    uint32_t cells[CELLS * CELLS] = {0};
    for (uint32_t i = 0; i < COUNT; i++)
        cells[(x[i] >> 28) * CELLS + (y[i] >> 28)]++;
    const double expected = (double)COUNT / (CELLS * CELLS);
    double sum = 0.0;
    for (uint32_t i = 0; i < CELLS * CELLS; i++)
        sum += (cells[i] - expected) * (cells[i] - expected) / expected;
    return sum / (CELLS * CELLS - 1);
}

// Any two dimensions of any two blocks, and of two seeds: as spread as chance would have it, on
// average and not far off for any. Runs of either are even, so that few numbers decide how they
// meet: the spread's own is wider than that of independent points. Those that are alike would
// have 60.
static void dimensions_are_not_alike(void **state)
{
    (void)state;
    uint4 *points = make_points(1);
    uint4 *others = make_points(2);
    uint32_t x[COUNT], y[COUNT];
    double sum = 0.0;
    const uint32_t count = 4 * rng_block_count(DEPTH);
    for (uint32_t a = 0; a < count; a++)
        for (uint32_t b = 0; b <= a; b++) {
            for (uint32_t i = 0; i < COUNT; i++) {
                x[i] = component(points[a / 4 * COUNT + i], a % 4);
                y[i] = component((a == b ? others : points)[b / 4 * COUNT + i], b % 4);
            }
            const double one = spread(x, y);
            assert_true(one < 3.0);
            sum += one;
        }
    assert_true(sum / (count * (count + 1) / 2) < 1.02);
    free(others);
    free(points);
}

// The bits below the boxes are no pattern.
static void low_bits_are_uniform(void **state)
{
    (void)state;
    uint4 *points = make_points(4);
    const uint32_t total = rng_block_count(DEPTH) * COUNT;
    for (uint32_t k = 0; k < 4; k++)
        for (uint32_t bit = 0; bit < 32; bit++) {
            double ones = 0.0;
            for (uint32_t i = 0; i < total; i++)
                ones += component(points[i], k) >> bit & 1u;
            assert_true(fabs(ones - 0.5 * total) < SIGMAS * 0.5 * sqrt(total));
        }
    free(points);
}

static void one_point_is_zero(void **state)
{
    (void)state;
    uint4 *points = NULL;
    assert_int_equal(samples_build(&points, 3, DEPTH, 0), 0);
    for (uint32_t i = 0; i < rng_block_count(DEPTH); i++)
        assert_true((points[i].x | points[i].y | points[i].z | points[i].w) == 0);
    free(points);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_dimension_is_even),  cmocka_unit_test(y_and_z_are_even_in_all_boxes),
        cmocka_unit_test(dimensions_are_not_alike), cmocka_unit_test(low_bits_are_uniform),
        cmocka_unit_test(one_point_is_zero),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
