// What textured triangles emit: against the mean of many points, and dark only where nothing can
// emit.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "core/clock.h"
#include "prep/color.h"
#include "prep/emission.h"
#include "prep_support.h"
#include "shared/material.h"

#define SIDE  64u
#define MANY  100000u
#define POWER 3.0f // of the factor, the same in R, G and B

// Triangles of one textured material.
struct fixture {
    uint8_t rgba[SIDE * SIDE * 4];
    struct scene_image image;
    struct scene_texture texture;
    struct scene_material material;
    struct scene scene;
    struct geometry geometry;
};

static void open_fixture(struct fixture *f, uint32_t triangle_count)
{
    *f = (struct fixture){
        .image = {.name = "", .width = SIDE, .height = SIDE, .rgba = f->rgba},
        .material = {.name = "",
                     .emission = {POWER, POWER, POWER},
                     .emissive_texture = {.uv_matrix = {1.0f, 0.0f, 0.0f, 1.0f}}},
        .geometry = make_soup(1, triangle_count, 10.0, 1.0),
    };
    f->scene = (struct scene){.images = &f->image,
                              .image_count = 1,
                              .textures = &f->texture,
                              .texture_count = 1,
                              .materials = &f->material,
                              .material_count = 1};
}

static void set_uv(struct fixture *f, uint32_t triangle, const float *uv)
{
    for (int i = 0; i < 3; i++) {
        f->geometry.vertices[3 * triangle + i].uv.x = uv[2 * i];
        f->geometry.vertices[3 * triangle + i].uv.y = uv[2 * i + 1];
    }
}

static void paint(struct fixture *f, uint32_t x, uint32_t y, uint8_t value)
{
    memset(&f->rgba[4 * (y * SIDE + x)], value, 3);
}

static double first_emission(struct fixture *f)
{
    struct emission emission;
    assert_int_equal(emission_build(&emission, &f->scene, &f->geometry), STATUS_OK);
    const double found = emission_of(&emission, &f->geometry, 0);
    emission_free(&emission);
    return found;
}

static void triangles_emit_the_mean_of_their_own_texels(void **state)
{
    (void)state;
    struct fixture f;
    open_fixture(&f, 1);
    for (uint32_t y = 0; y < SIDE; y++)
        for (uint32_t x = 0; x < SIDE; x++)
            paint(&f, x, y, x < SIDE / 2 ? 255 : 0);
    set_uv(&f, 0, (const float[]){0.1f, 0.1f, 0.4f, 0.1f, 0.1f, 0.9f}); // in the bright half
    assert_true(fabs(first_emission(&f) - POWER) < 1e-6);
    set_uv(&f, 0, (const float[]){0.6f, 0.1f, 0.9f, 0.1f, 0.6f, 0.9f}); // in the dark one
    assert_true(first_emission(&f) == 0.0);
    set_uv(&f, 0, (const float[]){0.1f, 0.1f, 0.9f, 0.1f, 0.5f, 0.9f}); // half and half
    assert_true(fabs(first_emission(&f) - 0.5 * POWER) < 0.02 * POWER);
    set_uv(&f, 0, (const float[]){0.0f, 0.0f, 0.98f, 0.0f, 0.0f, 0.98f}); // a corner more bright
    assert_true(fabs(first_emission(&f) - 0.74 * POWER) < 0.03 * POWER);
    geometry_free(&f.geometry);
}

// The value of a texture at a point, as kernels filter it.
static double value_at(const struct fixture *f, double u, double v)
{
    const double at[2] = {u, v};
    const uint32_t wraps[2] = {f->texture.wrap_s, f->texture.wrap_t};
    int64_t near[2], far[2];
    double blend[2];
    for (int k = 0; k < 2; k++) {
        double t = at[k];
        if (wraps[k] == TEXTURE_WRAP_CLAMP)
            t = fmin(fmax(t, 0.0), 1.0);
        else if (wraps[k] == TEXTURE_WRAP_MIRROR)
            t = fabs(remainder(t, 2.0));
        else
            t -= floor(t);
        const double x = t * SIDE - 0.5;
        near[k] = (int64_t)floor(x);
        far[k] = near[k] + 1;
        blend[k] = x - floor(x);
        const bool wrapped = wraps[k] == TEXTURE_WRAP_REPEAT;
        near[k] = near[k] < 0 ? (wrapped ? (int64_t)SIDE - 1 : 0) : near[k];
        far[k] = far[k] >= (int64_t)SIDE ? (wrapped ? 0 : (int64_t)SIDE - 1) : far[k];
    }
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        const int64_t x = i & 1 ? far[0] : near[0];
        const int64_t y = i & 2 ? far[1] : near[1];
        sum += (i & 1 ? blend[0] : 1.0 - blend[0]) * (i & 2 ? blend[1] : 1.0 - blend[1]) *
               color_from_srgb(f->rgba[4 * (y * SIDE + x)] / 255.0);
    }
    return sum;
}

// Sparse texels, triangles of all sizes, all wraps: whatever emits somewhere has power.
static void what_can_emit_is_never_dark(void **state)
{
    (void)state;
    struct fixture f;
    uint64_t seed = 3;
    const uint32_t count = 3000;
    uint32_t dark = 0;
    open_fixture(&f, count);
    for (int i = 0; i < 12; i++)
        paint(&f, (uint32_t)(random_unit(&seed) * SIDE), (uint32_t)(random_unit(&seed) * SIDE),
              255);
    for (uint32_t wrap = 0; wrap < 9; wrap++) {
        f.texture.wrap_s = wrap / 3;
        f.texture.wrap_t = wrap % 3;
        for (uint32_t i = 0; i < count; i++) {
            float uv[6];
            const double size = pow(10.0, random_between(&seed, -3.0, 0.3));
            const double u = random_between(&seed, -3.0, 3.0);
            const double v = random_between(&seed, -3.0, 3.0);
            for (int k = 0; k < 6; k++)
                uv[k] = (float)((k & 1 ? v : u) + random_between(&seed, -size, size));
            set_uv(&f, i, uv);
        }
        struct emission emission;
        assert_int_equal(emission_build(&emission, &f.scene, &f.geometry), STATUS_OK);
        for (uint32_t i = 0; i < count; i++) {
            if (emission_of(&emission, &f.geometry, i) > 0.0)
                continue;
            dark++;
            const struct vertex *corner = &f.geometry.vertices[3 * (size_t)i];
            for (int k = 0; k < 40; k++) {
                double s = random_unit(&seed);
                double t = random_unit(&seed);
                if (s + t > 1.0) {
                    s = 1.0 - s;
                    t = 1.0 - t;
                }
                const double u =
                    corner[0].uv.x * (1.0 - s - t) + corner[1].uv.x * s + corner[2].uv.x * t;
                const double v =
                    corner[0].uv.y * (1.0 - s - t) + corner[1].uv.y * s + corner[2].uv.y * t;
                assert_true(value_at(&f, u, v) == 0.0);
            }
        }
        emission_free(&emission);
    }
    assert_true(dark > count); // of nine times as many
    geometry_free(&f.geometry);
}

static void many_triangles_are_measured(void **state)
{
    (void)state;
    struct fixture f;
    uint64_t seed = 4;
    open_fixture(&f, MANY);
    for (uint32_t i = 0; i < SIDE * SIDE; i++)
        paint(&f, i % SIDE, i / SIDE, (uint8_t)(random_unit(&seed) * 256.0));
    for (uint32_t i = 0; i < MANY; i++) {
        float uv[6];
        for (int k = 0; k < 6; k++)
            uv[k] = (float)random_unit(&seed);
        set_uv(&f, i, uv);
    }
    const double start_s = clock_seconds();
    assert_true(first_emission(&f) > 0.0);
    print_message("%u textured triangles in %.2f s\n", MANY, clock_seconds() - start_s);
    geometry_free(&f.geometry);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(triangles_emit_the_mean_of_their_own_texels),
        cmocka_unit_test(what_can_emit_is_never_dark),
        cmocka_unit_test(many_triangles_are_measured),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
