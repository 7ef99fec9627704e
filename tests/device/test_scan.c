// Prefix sums against a loop.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdlib.h>

#include "prep/prep_support.h"
#include "support.h"

#define GROUPS   5u
#define GUARD    8u // elements behind the array that have to stay as they were
#define SENTINEL 0xdeadbeefu

// Group size, run and tile of the device.
static void read_sizes(uint32_t *sizes, struct gpu *gpu, const struct program *program)
{
    struct buffer out = device_buffer(gpu, NULL, 3 * sizeof(uint32_t));
    const struct kernel_arg args[] = {ARG_BUFFER(&out)};
    DEVICE_RUN(gpu, program, "scan_sizes", args, 1);
    assert_ok(buffer_read(gpu, &out, sizes, 3 * sizeof(uint32_t)));
    buffer_free(gpu, &out);
}

// Small numbers, many of them 0, as counts are; now and then a large one.
static void fill(uint32_t *values, size_t count, uint64_t *seed)
{
    for (size_t i = 0; i < count; i++)
        values[i] = random_unit(seed) < 0.01 ? 1u << 20 : (uint32_t)(random_unit(seed) * 4.0);
}

static void tiles_are_made_of_runs(void **state)
{
    struct gpu *gpu = device_of(state);
    struct program program = device_program(gpu, "scan", NULL);
    uint32_t sizes[3];
    read_sizes(sizes, gpu, &program);
    assert_int_equal(sizes[0] * sizes[1], sizes[2]);
    assert_true(sizes[2] >= 16); // the wavefront's scratch counts on it
    program_free(&program);
}

static void scan_group_agrees_with_a_loop(void **state)
{
    struct gpu *gpu = device_of(state);
    struct program program = device_program(gpu, "scan", NULL);
    uint32_t sizes[3];
    read_sizes(sizes, gpu, &program);
    const uint32_t count = GROUPS * sizes[0];
    uint64_t seed = 1;
    uint32_t *values = malloc(count * sizeof(*values));
    uint32_t *sums = malloc(count * sizeof(*sums));
    uint32_t totals[GROUPS];
    fill(values, count, &seed);

    struct buffer values_buffer = device_buffer(gpu, values, count * sizeof(*values));
    struct buffer totals_buffer = device_buffer(gpu, NULL, sizeof(totals));
    const struct kernel_arg args[] = {ARG_BUFFER(&values_buffer), ARG_BUFFER(&totals_buffer)};
    DEVICE_RUN(gpu, &program, "scan_groups", args, count);
    assert_ok(buffer_read(gpu, &values_buffer, sums, count * sizeof(*sums)));
    assert_ok(buffer_read(gpu, &totals_buffer, totals, sizeof(totals)));
    for (uint32_t group = 0; group < GROUPS; group++) {
        uint32_t before = 0;
        for (uint32_t i = group * sizes[0]; i < (group + 1) * sizes[0]; i++) {
            assert_int_equal(sums[i], before);
            before += values[i];
        }
        assert_int_equal(totals[group], before);
    }
    buffer_free(gpu, &totals_buffer);
    buffer_free(gpu, &values_buffer);
    free(sums);
    free(values);
    program_free(&program);
}

static void check_array(struct gpu *gpu, const struct program *program, uint32_t count,
                        uint32_t group_size)
{
    uint64_t seed = count;
    const size_t size = (count + GUARD) * sizeof(uint32_t);
    uint32_t *values = malloc(size);
    uint32_t *sums = malloc(size);
    uint32_t *totals = malloc(group_size * sizeof(*totals));
    fill(values, count, &seed);
    for (uint32_t i = count; i < count + GUARD; i++)
        values[i] = SENTINEL;

    struct buffer values_buffer = device_buffer(gpu, values, size);
    struct buffer totals_buffer = device_buffer(gpu, NULL, group_size * sizeof(*totals));
    const struct kernel_arg args[] = {ARG_BUFFER(&values_buffer), ARG_VALUE(count),
                                      ARG_BUFFER(&totals_buffer)};
    DEVICE_RUN(gpu, program, "scan_whole", args, 1);
    assert_ok(buffer_read(gpu, &values_buffer, sums, size));
    assert_ok(buffer_read(gpu, &totals_buffer, totals, group_size * sizeof(*totals)));
    uint32_t before = 0;
    for (uint32_t i = 0; i < count; i++) {
        assert_int_equal(sums[i], before);
        before += values[i];
    }
    for (uint32_t i = 0; i < group_size; i++)
        assert_int_equal(totals[i], before);
    for (uint32_t i = count; i < count + GUARD; i++)
        assert_int_equal(sums[i], SENTINEL);
    buffer_free(gpu, &totals_buffer);
    buffer_free(gpu, &values_buffer);
    free(totals);
    free(sums);
    free(values);
}

static void scan_array_agrees_with_a_loop(void **state)
{
    struct gpu *gpu = device_of(state);
    struct program program = device_program(gpu, "scan", NULL);
    uint32_t sizes[3];
    read_sizes(sizes, gpu, &program);
    const uint32_t group = sizes[0];
    const uint32_t tile = sizes[2];
    const uint32_t counts[] = {0,        1,    2,        group - 1, group,        group + 1,
                               tile - 1, tile, tile + 1, 2 * tile,  2 * tile + 1, 7 * tile + 3,
                               300000};
    for (size_t i = 0; i < sizeof(counts) / sizeof(counts[0]); i++)
        check_array(gpu, &program, counts[i], group);
    program_free(&program);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(tiles_are_made_of_runs),
        cmocka_unit_test(scan_group_agrees_with_a_loop),
        cmocka_unit_test(scan_array_agrees_with_a_loop),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
