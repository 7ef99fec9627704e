// Functions that are compiled twice give the same on both sides.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>

#include "prep/prep_support.h"
#include "shared/oct.h"
#include "shared/rng.h"
#include "shared/zorder.h"
#include "support.h"

#define COUNT       100000u
#define OCT_STEP    1       // codes a packed coordinate may differ by: products may be fused
#define OCT_EPSILON 0x1p-22 // a few roundings of numbers up to 1, fused or not

static uint32_t random_word(uint64_t *seed)
{
    return (uint32_t)(random_unit(seed) * 0x1p32);
}

static void rng_agrees_bit_for_bit(void **state)
{
    struct gpu *gpu = device_of(state);
    uint64_t seed = 1;
    uint4 *in = malloc(COUNT * sizeof(*in));
    uint4 *bits = malloc(COUNT * sizeof(*bits));
    float *units = malloc(COUNT * sizeof(*units));
    uint32_t *dimensions = malloc(COUNT * sizeof(*dimensions));
    for (uint32_t i = 0; i < COUNT; i++)
        in[i] =
            (uint4){random_word(&seed), random_word(&seed), random_word(&seed), random_word(&seed)};
    in[0] = (uint4){0, 0, 0, 0};
    in[1] = (uint4){UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};

    struct program program = device_program(gpu, "parity", NULL);
    struct buffer in_buffer = device_buffer(gpu, in, COUNT * sizeof(*in));
    struct buffer bits_buffer = device_buffer(gpu, NULL, COUNT * sizeof(*bits));
    struct buffer units_buffer = device_buffer(gpu, NULL, COUNT * sizeof(*units));
    struct buffer dimensions_buffer = device_buffer(gpu, NULL, COUNT * sizeof(*dimensions));
    const uint32_t count = COUNT;
    const struct kernel_arg args[] = {ARG_BUFFER(&in_buffer), ARG_BUFFER(&bits_buffer),
                                      ARG_BUFFER(&units_buffer), ARG_BUFFER(&dimensions_buffer),
                                      ARG_VALUE(count)};
    DEVICE_RUN(gpu, &program, "parity_rng", args, count);
    assert_ok(buffer_read(gpu, &bits_buffer, bits, COUNT * sizeof(*bits)));
    assert_ok(buffer_read(gpu, &units_buffer, units, COUNT * sizeof(*units)));
    assert_ok(buffer_read(gpu, &dimensions_buffer, dimensions, COUNT * sizeof(*dimensions)));

    for (uint32_t i = 0; i < COUNT; i++) {
        const uint4 host = rng_bits(in[i].x, in[i].y, in[i].z, in[i].w);
        assert_memory_equal(&bits[i], &host, sizeof(host));
        assert_int_equal(float_bits(units[i]), float_bits(rng_unit(in[i].x)));
        assert_int_equal(dimensions[i], rng_dimension(in[i].x & 255u, in[i].y & 7u, in[i].z));
    }
    buffer_free(gpu, &dimensions_buffer);
    buffer_free(gpu, &units_buffer);
    buffer_free(gpu, &bits_buffer);
    buffer_free(gpu, &in_buffer);
    program_free(&program);
    free(dimensions);
    free(units);
    free(bits);
    free(in);
}

static void zorder_agrees_bit_for_bit(void **state)
{
    struct gpu *gpu = device_of(state);
    uint64_t seed = 2;
    uint4 *in = malloc(COUNT * sizeof(*in));
    uint32_t *pixels = malloc(COUNT * sizeof(*pixels));
    for (uint32_t i = 0; i < COUNT; i++) {
        const uint32_t width = 1 + (uint32_t)(pow(random_unit(&seed), 4.0) * 65000.0);
        const uint32_t height = 1 + (uint32_t)(pow(random_unit(&seed), 4.0) * 65000.0);
        const double pixel_count = (double)width * height;
        in[i] = (uint4){(uint32_t)(random_unit(&seed) * pixel_count), width, height, 0};
    }

    struct program program = device_program(gpu, "parity", NULL);
    struct buffer in_buffer = device_buffer(gpu, in, COUNT * sizeof(*in));
    struct buffer pixels_buffer = device_buffer(gpu, NULL, COUNT * sizeof(*pixels));
    const uint32_t count = COUNT;
    const struct kernel_arg args[] = {ARG_BUFFER(&in_buffer), ARG_BUFFER(&pixels_buffer),
                                      ARG_VALUE(count)};
    DEVICE_RUN(gpu, &program, "parity_zorder", args, count);
    assert_ok(buffer_read(gpu, &pixels_buffer, pixels, COUNT * sizeof(*pixels)));
    for (uint32_t i = 0; i < COUNT; i++)
        assert_int_equal(pixels[i], zorder_pixel(in[i].x, in[i].y, in[i].z));
    buffer_free(gpu, &pixels_buffer);
    buffer_free(gpu, &in_buffer);
    program_free(&program);
    free(pixels);
    free(in);
}

// Whether two coordinates of a packed vector are the same but for rounding.
static int is_near(uint32_t a, uint32_t b)
{
    return abs((int)(int16_t)a - (int)(int16_t)b) <= OCT_STEP;
}

// Unit vectors, the axes and edges of the octahedron first.
static float4 make_normal(uint32_t i, uint64_t *seed)
{
    double v[3], length = 0.0;
    for (int k = 0; k < 3; k++) {
        v[k] = i < 27 ? (double)(i /
                                 (k == 0   ? 1
                                  : k == 1 ? 3
                                           : 9) %
                                 3) -
                            1.0
                      : random_between(seed, -1.0, 1.0);
        length += v[k] * v[k];
    }
    if (length == 0.0)
        return (float4){0.0f, 0.0f, 1.0f, 0.0f};
    length = sqrt(length);
    return (float4){(float)(v[0] / length), (float)(v[1] / length), (float)(v[2] / length), 0.0f};
}

static void oct_agrees_but_for_rounding(void **state)
{
    struct gpu *gpu = device_of(state);
    uint64_t seed = 3;
    float4 *normals = malloc(COUNT * sizeof(*normals));
    uint32_t *words = malloc(COUNT * sizeof(*words));
    uint32_t *packed = malloc(COUNT * sizeof(*packed));
    float4 *unpacked = malloc(COUNT * sizeof(*unpacked));
    for (uint32_t i = 0; i < COUNT; i++) {
        normals[i] = make_normal(i, &seed);
        words[i] = random_word(&seed);
    }

    struct program program = device_program(gpu, "parity", NULL);
    struct buffer normals_buffer = device_buffer(gpu, normals, COUNT * sizeof(*normals));
    struct buffer words_buffer = device_buffer(gpu, words, COUNT * sizeof(*words));
    struct buffer packed_buffer = device_buffer(gpu, NULL, COUNT * sizeof(*packed));
    struct buffer unpacked_buffer = device_buffer(gpu, NULL, COUNT * sizeof(*unpacked));
    const uint32_t count = COUNT;
    const struct kernel_arg args[] = {ARG_BUFFER(&normals_buffer), ARG_BUFFER(&words_buffer),
                                      ARG_BUFFER(&packed_buffer), ARG_BUFFER(&unpacked_buffer),
                                      ARG_VALUE(count)};
    DEVICE_RUN(gpu, &program, "parity_oct", args, count);
    assert_ok(buffer_read(gpu, &packed_buffer, packed, COUNT * sizeof(*packed)));
    assert_ok(buffer_read(gpu, &unpacked_buffer, unpacked, COUNT * sizeof(*unpacked)));
    for (uint32_t i = 0; i < COUNT; i++) {
        const uint32_t code = oct_pack(normals[i].x, normals[i].y, normals[i].z);
        assert_true(is_near(packed[i], code) && is_near(packed[i] >> 16, code >> 16));
        const float4 n = oct_unpack(words[i]);
        assert_close3(unpacked[i], ((double[3]){n.x, n.y, n.z}), OCT_EPSILON);
    }
    buffer_free(gpu, &unpacked_buffer);
    buffer_free(gpu, &packed_buffer);
    buffer_free(gpu, &words_buffer);
    buffer_free(gpu, &normals_buffer);
    program_free(&program);
    free(unpacked);
    free(packed);
    free(words);
    free(normals);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rng_agrees_bit_for_bit),
        cmocka_unit_test(zorder_agrees_bit_for_bit),
        cmocka_unit_test(oct_agrees_but_for_rounding),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
