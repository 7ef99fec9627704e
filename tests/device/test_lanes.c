// Eight paths side by side compute what each does alone.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prep/prep_support.h"
#include "prep/samples.h"
#include "shared/path.h"
#include "shared/rng.h"
#include "shared/settings.h"
#include "support.h"

#define COUNT       8192u
#define PIXELS      100000u
#define POINT_SHIFT 6u
#define DEPTH       2u
#define OCT_STEP    1    // codes a packed coordinate may differ by: products may be fused
#define EPSILON     2e-6 // some roundings of numbers up to 1, fused or not

// As in lanes.cl.
struct lanes_case {
    float4 numbers, normal, dir, shares, weights, place;
};

struct cases {
    uint32_t places[PIXELS]; // of pixels, all different
    float4 vectors[COUNT], units[COUNT];
    uint32_t words[COUNT];
    struct lanes_case single[COUNT], lanes[COUNT];
};

static void make_cases(struct cases *c)
{
    uint64_t seed = 1;
    for (uint32_t i = 0; i < PIXELS; i++)
        c->places[i] = i ^ 5u;
    for (uint32_t i = 0; i < COUNT; i++) {
        double v[3], length = 0.0;
        while (length < 1e-4) {
            length = 0.0;
            for (int k = 0; k < 3; k++) {
                v[k] = i < 64 ? floor(random_between(&seed, -1.0, 2.0)) // on axes and edges, too
                              : random_between(&seed, -1.0, 1.0);
                length += v[k] * v[k];
            }
        }
        length = sqrt(length);
        c->vectors[i] =
            (float4){(float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length), 0.0f};
        c->units[i] = (float4){(float)random_unit(&seed), (float)random_unit(&seed),
                               (float)random_unit(&seed), (float)random_unit(&seed)};
        c->words[i] = (uint32_t)(random_unit(&seed) * 0x1p32);
    }
}

static void run(struct gpu *gpu, struct cases *c, const struct batch *batch, const char *source)
{
    const struct settings settings = {.seed = 5,
                                      .depth = DEPTH,
                                      .shadow_rays = 1,
                                      .roulette_depth = 2,
                                      .point_shift = POINT_SHIFT};
    const uint32_t count = COUNT;
    uint4 *points = NULL;
    assert_ok(samples_build(&points, settings.seed, DEPTH, POINT_SHIFT));
    const size_t points_size = ((size_t)rng_block_count(DEPTH) << POINT_SHIFT) * sizeof(*points);
    struct program program = device_program(gpu, source, NULL);
    struct buffer buffers[] = {
        device_buffer(gpu, &settings, sizeof(settings)),
        device_buffer(gpu, points, points_size),
        device_buffer(gpu, c->places, sizeof(c->places)),
        device_buffer(gpu, c->vectors, sizeof(c->vectors)),
        device_buffer(gpu, c->words, sizeof(c->words)),
        device_buffer(gpu, c->units, sizeof(c->units)),
        device_buffer(gpu, NULL, sizeof(c->single)),
    };
    const struct kernel_arg args[] = {
        ARG_BUFFER(&buffers[0]), ARG_VALUE(*batch),       ARG_BUFFER(&buffers[1]),
        ARG_BUFFER(&buffers[2]), ARG_BUFFER(&buffers[3]), ARG_BUFFER(&buffers[4]),
        ARG_BUFFER(&buffers[5]), ARG_VALUE(count),        ARG_BUFFER(&buffers[6]),
    };
    DEVICE_RUN(gpu, &program, "lanes_single", args, count);
    assert_ok(buffer_read(gpu, &buffers[6], c->single, sizeof(c->single)));
    DEVICE_RUN(gpu, &program, "lanes_together", args, count);
    assert_ok(buffer_read(gpu, &buffers[6], c->lanes, sizeof(c->lanes)));
    for (size_t i = 0; i < sizeof(buffers) / sizeof(buffers[0]); i++)
        buffer_free(gpu, &buffers[i]);
    program_free(&program);
    free(points);
}

static void assert_row(const float4 *row, const float4 *expected)
{
    const float *a = &row->x;
    const float *b = &expected->x;
    for (int k = 0; k < 4; k++)
        assert_close(a[k], b[k], EPSILON);
}

static int is_near(uint32_t a, uint32_t b)
{
    return abs((int)(int16_t)a - (int)(int16_t)b) <= OCT_STEP;
}

static void assert_like_single_paths(void **state, const char *source)
{
    struct gpu *gpu = device_of(state);
    struct cases *c = calloc(1, sizeof(*c));
    const struct batch batches[] = {
        {.count = COUNT, .pixel_count = PIXELS, .first = 77},
        {.count = COUNT, .pixel_count = 100, .first = 399, .first_sample = 9, .sample_shift = 2},
        {.count = COUNT, .pixel_count = 513, .first_pixel = 1000, .sample_shift = 4},
    };
    make_cases(c);
    for (size_t b = 0; b < sizeof(batches) / sizeof(batches[0]); b++) {
        run(gpu, c, &batches[b], source);
        for (uint32_t i = 0; i < COUNT; i++) {
            const struct lanes_case *lanes = &c->lanes[i];
            const struct lanes_case *single = &c->single[i];
            assert_memory_equal(&lanes->numbers, &single->numbers, sizeof(single->numbers));
            assert_memory_equal(&lanes->place, &single->place, 2 * sizeof(float));
            const uint32_t packed = float_bits(lanes->place.z);
            const uint32_t expected = float_bits(single->place.z);
            assert_true(is_near(packed, expected) && is_near(packed >> 16, expected >> 16));
            assert_row(&lanes->normal, &single->normal);
            assert_row(&lanes->dir, &single->dir);
            assert_row(&lanes->shares, &single->shares);
            assert_row(&lanes->weights, &single->weights);
        }
    }
    free(c);
}

static void eight_compute_what_single_paths_do(void **state)
{
    assert_like_single_paths(state, "lanes");
}

static void sixteen_compute_what_single_paths_do(void **state)
{
    assert_like_single_paths(state, "lanes_sixteen");
}

static void plain_opencl_computes_the_same(void **state)
{
    assert_like_single_paths(state, "lanes_portable");
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(eight_compute_what_single_paths_do),
        cmocka_unit_test(sixteen_compute_what_single_paths_do),
        cmocka_unit_test(plain_opencl_computes_the_same),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
