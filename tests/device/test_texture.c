// Texture lookups against a twin in double precision.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "prep/prep_support.h"
#include "shared/material.h"
#include "support.h"

#define UVS           20000u
#define TEXEL_FIRST   5u // texels of others before the texture's in the pool
#define CODES         256u
#define SRGB_EPSILON  2e-6    // relative: the table has eight digits; GPUs compute powr
#define PLACE_EPSILON 0x1p-22 // of a coordinate, relative to its size and to 1: two roundings
#define BLEND_EPSILON 2e-6    // of a value: the sum of four products up to 1

struct fixture {
    struct gpu *gpu;
    struct program program;
};

// A texture and how it is asked.
struct texture {
    uint32_t width, height;
    uint32_t *texels; // [TEXEL_FIRST + width * height]
    struct texture_slot slot;
};

static void make_texture(struct texture *out, uint32_t width, uint32_t height, uint32_t flags)
{
    uint64_t seed = 31 * width + height;
    const uint32_t count = width * height;
    *out = (struct texture){.width = width, .height = height};
    out->texels = malloc((TEXEL_FIRST + count) * sizeof(*out->texels));
    for (uint32_t i = 0; i < TEXEL_FIRST + count; i++)
        out->texels[i] = (uint32_t)(random_unit(&seed) * 0x1p32);
    out->slot = (struct texture_slot){.uv_matrix = {1.0f, 0.0f, 0.0f, 1.0f},
                                      .texel_first = TEXEL_FIRST,
                                      .size = width | height << 16,
                                      .flags = TEXTURE_PRESENT | flags};
}

static uint32_t wrap_flags(uint32_t s, uint32_t t)
{
    return s << TEXTURE_WRAP_S_SHIFT | t << TEXTURE_WRAP_T_SHIFT;
}

// ---- the twin

static double decode(uint32_t code, bool srgb)
{
    const double c = code / 255.0;
    if (!srgb)
        return c;
    return c <= 0.04045 ? c / 12.92 : pow((c + 0.055) / 1.055, 2.4);
}

// The texel that stands at any place of the endless pattern.
static int64_t wrap(int64_t i, int64_t size, uint32_t mode)
{
    const int64_t period = mode == TEXTURE_WRAP_MIRROR ? 2 * size : size;
    if (mode == TEXTURE_WRAP_CLAMP)
        return i < 0 ? 0 : i >= size ? size - 1 : i;
    i = ((i % period) + period) % period;
    return i < size ? i : period - 1 - i;
}

static double texel_at(const struct texture *t, int64_t x, int64_t y, int channel)
{
    const uint32_t flags = t->slot.flags;
    const int64_t column = wrap(x, t->width, flags >> TEXTURE_WRAP_S_SHIFT & 3u);
    const int64_t row = wrap(y, t->height, flags >> TEXTURE_WRAP_T_SHIFT & 3u);
    const uint32_t texel = t->texels[TEXEL_FIRST + row * t->width + column];
    return decode(texel >> (8 * channel) & 255u, channel < 3 && (flags & TEXTURE_SRGB) != 0);
}

static void transform(double *out, const struct texture *t, const float4 uv)
{
    const float4 m = t->slot.uv_matrix;
    const bool second = (t->slot.flags & TEXTURE_UV1) != 0;
    const double u = second ? uv.z : uv.x;
    const double v = second ? uv.w : uv.y;
    out[0] = m.x * u + m.y * v + t->slot.uv_offset.x;
    out[1] = m.z * u + m.w * v + t->slot.uv_offset.y;
}

// Bilinear, of the endless pattern of texels.
static void fetch_bilinear(double *out, const struct texture *t, const double *uv)
{
    const double x = uv[0] * t->width - 0.5;
    const double y = uv[1] * t->height - 0.5;
    const int64_t column = (int64_t)floor(x);
    const int64_t row = (int64_t)floor(y);
    const double fx = x - column;
    const double fy = y - row;
    for (int k = 0; k < 4; k++)
        out[k] = (1.0 - fy) * ((1.0 - fx) * texel_at(t, column, row, k) +
                               fx * texel_at(t, column + 1, row, k)) +
                 fy * ((1.0 - fx) * texel_at(t, column, row + 1, k) +
                       fx * texel_at(t, column + 1, row + 1, k));
}

// ---- asking the device

enum source { POOL, LANES, IMAGE, SOURCES };

static const char *const kernel_names[SOURCES] = {"texture_from_pool", "texture_from_lanes",
                                                  "texture_from_image"};

static float4 *fetch(const struct fixture *f, const struct texture *t, const float4 *uvs,
                     enum source source)
{
    float4 *out = malloc(UVS * sizeof(*out));
    struct buffer texels;
    if (source == IMAGE)
        assert_ok(buffer_create_image(&texels, f->gpu, t->width, t->height, t->texels + TEXEL_FIRST,
                                      "a test's texture"));
    else
        texels = device_buffer(f->gpu, t->texels,
                               (TEXEL_FIRST + t->width * t->height) * sizeof(uint32_t));
    struct material material = {.textures = {[TEXTURE_BASE] = t->slot}};
    struct buffer slot = source == LANES ? device_buffer(f->gpu, &material, sizeof(material))
                                         : device_buffer(f->gpu, &t->slot, sizeof(t->slot));
    struct buffer uv_buffer = device_buffer(f->gpu, uvs, UVS * sizeof(*uvs));
    struct buffer out_buffer = device_buffer(f->gpu, NULL, UVS * sizeof(*out));
    const uint32_t count = UVS;
    const struct kernel_arg args[] = {ARG_BUFFER(&texels), ARG_BUFFER(&slot),
                                      ARG_BUFFER(&uv_buffer), ARG_VALUE(count),
                                      ARG_BUFFER(&out_buffer)};
    DEVICE_RUN(f->gpu, &f->program, kernel_names[source], args, count);
    assert_ok(buffer_read(f->gpu, &out_buffer, out, UVS * sizeof(*out)));
    buffer_free(f->gpu, &out_buffer);
    buffer_free(f->gpu, &uv_buffer);
    buffer_free(f->gpu, &slot);
    buffer_free(f->gpu, &texels);
    return out;
}

// Coordinates of all sizes and signs, and those on the borders of texels and of the texture.
static float4 *make_uvs(const struct texture *t)
{
    uint64_t seed = 1;
    float4 *uvs = malloc(UVS * sizeof(*uvs));
    for (uint32_t i = 0; i < UVS; i++) {
        float *uv = &uvs[i].x;
        const double reach = pow(10.0, (int)(i % 5) - 1); // 0.1 to 1000
        for (int k = 0; k < 4; k++)
            uv[k] = (float)random_between(&seed, -reach, reach);
        if (i % 7 == 0)
            uv[i % 2] = (float)((int)(i % 9) - 4);
        if (i % 7 == 1)
            uv[i % 2] = (float)((int)(i % 33) - 16) / (float)(i % 4 < 2 ? t->width : t->height);
        if (i % 7 == 2)
            uv[i % 2] = i % 4 < 2 ? -1e-12f : 0.99999994f;
    }
    return uvs;
}

// What a coordinate may be off by.
static double place_error(const struct texture *t, const float4 uv)
{
    const float4 m = t->slot.uv_matrix;
    const double matrix = fmax(fabs(m.x) + fabs(m.y), fabs(m.z) + fabs(m.w));
    const double size = fmax(fmax(fabs(uv.x), fabs(uv.y)), fmax(fabs(uv.z), fabs(uv.w)));
    const bool exact = m.x == 1.0f && m.y == 0.0f && m.z == 0.0f && m.w == 1.0f &&
                       t->slot.uv_offset.x == 0.0f && t->slot.uv_offset.y == 0.0f;
    const double offset = fmax(fabs(t->slot.uv_offset.x), fabs(t->slot.uv_offset.y));
    return PLACE_EPSILON * (exact ? 1.0 : 1.0 + matrix * size + offset);
}

static void check_bilinear(const struct texture *t, const float4 *uvs, const float4 *found)
{
    for (uint32_t i = 0; i < UVS; i++) {
        double uv[2], expected[4];
        transform(uv, t, uvs[i]);
        fetch_bilinear(expected, t, uv);

        // Neighbours differ by 1 at most, on either axis.
        const double error = BLEND_EPSILON + place_error(t, uvs[i]) * (t->width + t->height);
        assert_close3(found[i], expected, error);
        assert_close(found[i].w, expected[3], error);
    }
}

// The texel under the place, or one that it may be after rounding.
static void check_nearest(const struct texture *t, const float4 *uvs, const float4 *found)
{
    for (uint32_t i = 0; i < UVS; i++) {
        double uv[2];
        transform(uv, t, uvs[i]);
        const double error = place_error(t, uvs[i]);
        bool matches = false;
        for (int corner = 0; corner < 9 && !matches; corner++) {
            const int64_t x = (int64_t)floor((uv[0] + (corner % 3 - 1) * error) * t->width);
            const int64_t y = (int64_t)floor((uv[1] + (corner / 3 - 1) * error) * t->height);
            matches = true;
            for (int k = 0; k < 4; k++)
                matches = matches && fabs((&found[i].x)[k] - texel_at(t, x, y, k)) <= SRGB_EPSILON;
        }
        assert_true(matches);
    }
}

// Asks the pool, by itself and by eights, and, where there are any, an image. They need not agree
// to the last bit: compilers may fuse products in one kernel and not in the other.
static void check_texture(const struct fixture *f, struct texture *t)
{
    float4 *uvs = make_uvs(t);
    for (int source = POOL; source < (f->gpu->info.has_images ? SOURCES : IMAGE); source++) {
        float4 *found = fetch(f, t, uvs, (enum source)source);
        if (t->slot.flags & TEXTURE_NEAREST)
            check_nearest(t, uvs, found);
        else
            check_bilinear(t, uvs, found);
        free(found);
    }
    free(uvs);
    free(t->texels);
}

static struct fixture make_fixture(void **state)
{
    struct gpu *gpu = device_of(state);
    return (struct fixture){gpu, device_program(gpu, "texture", NULL)};
}

// ---- laws

static void every_size_and_wrap_agrees(void **state)
{
    struct fixture f = make_fixture(state);
    static const uint32_t sizes[][2] = {{1, 1}, {1, 5}, {2, 2}, {7, 1}, {16, 16}, {13, 37}};
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        for (uint32_t mode = 0; mode < 3 * 3; mode++) {
            struct texture t;
            const uint32_t flags = wrap_flags(mode % 3, mode / 3);
            make_texture(&t, sizes[i][0], sizes[i][1], flags);
            check_texture(&f, &t);
            make_texture(&t, sizes[i][0], sizes[i][1], flags | TEXTURE_NEAREST);
            check_texture(&f, &t);
        }
    }
    program_free(&f.program);
}

static void srgb_is_decoded_before_filtering(void **state)
{
    struct fixture f = make_fixture(state);
    struct texture t;
    make_texture(&t, 9, 4, TEXTURE_SRGB);
    check_texture(&f, &t);
    make_texture(&t, 9, 4, TEXTURE_SRGB | TEXTURE_NEAREST);
    check_texture(&f, &t);
    program_free(&f.program);
}

static void uvs_are_chosen_and_transformed(void **state)
{
    struct fixture f = make_fixture(state);
    for (uint32_t flags = 0; flags <= TEXTURE_UV1; flags += TEXTURE_UV1) {
        struct texture t;
        make_texture(&t, 12, 10, flags);
        t.slot.uv_matrix = (float4){1.5f, -0.7f, 0.25f, 2.0f};
        t.slot.uv_offset = (float2){-3.3f, 0.4f};
        check_texture(&f, &t);
    }
    program_free(&f.program);
}

static void missing_textures_are_white(void **state)
{
    struct fixture f = make_fixture(state);
    struct texture t;
    make_texture(&t, 3, 3, 0);
    t.slot.flags = 0;
    float4 *uvs = make_uvs(&t);
    float4 *found = fetch(&f, &t, uvs, POOL);
    for (uint32_t i = 0; i < UVS; i++)
        assert_true(found[i].x == 1.0f && found[i].y == 1.0f && found[i].z == 1.0f &&
                    found[i].w == 1.0f);
    free(found);
    free(uvs);
    free(t.texels);
    program_free(&f.program);
}

static void every_code_is_decoded_by_the_formula(void **state)
{
    struct fixture f = make_fixture(state);
    uint32_t texels[CODES];
    float4 found[2 * CODES];
    for (uint32_t i = 0; i < CODES; i++)
        texels[i] = i | (CODES - 1 - i) << 8 | (i * 7 & 255u) << 16 | (i * 13 & 255u) << 24;
    struct buffer in = device_buffer(f.gpu, texels, sizeof(texels));
    struct buffer out = device_buffer(f.gpu, NULL, sizeof(found));
    const uint32_t count = CODES;
    const struct kernel_arg args[] = {ARG_BUFFER(&in), ARG_VALUE(count), ARG_BUFFER(&out)};
    DEVICE_RUN(f.gpu, &f.program, "texture_decoded", args, count);
    assert_ok(buffer_read(f.gpu, &out, found, sizeof(found)));
    for (uint32_t i = 0; i < 2 * CODES; i++) {
        for (int k = 0; k < 4; k++) {
            const double expected = decode(texels[i / 2] >> (8 * k) & 255u, k < 3 && i % 2 == 0);
            assert_close((&found[i].x)[k], expected, SRGB_EPSILON * expected);
        }
    }
    buffer_free(f.gpu, &out);
    buffer_free(f.gpu, &in);
    program_free(&f.program);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_size_and_wrap_agrees),
        cmocka_unit_test(srgb_is_decoded_before_filtering),
        cmocka_unit_test(uvs_are_chosen_and_transformed),
        cmocka_unit_test(missing_textures_are_white),
        cmocka_unit_test(every_code_is_decoded_by_the_formula),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
