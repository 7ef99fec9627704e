// Drawing directions from the BSDFs: they have the density that is said, and weigh what they
// should.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "bsdf_fixture.h"

#define WEIGHT_EPSILON 2e-4 // relative: draws and values are rounded apart, then divided
#define BINS           256u // of the histogram: 16 by 16 blocks of cells
#define LEAST_EXPECTED 20.0 // samples in a bin for its spread to be a normal one's

static bool is_drawn(const struct bsdf_draw *draw)
{
    const float4 d = draw->dir_density;
    return d.x != 0.0f || d.y != 0.0f || d.z != 0.0f;
}

// The density's integral is the part of draws that end above the surface, the mirror's apart.
static void check_density(enum model model, const struct bsdf_case *c)
{
    evaluate_sphere(&fixture, model, c);
    draw(&fixture, model, c);
    double integral = 0.0;
    double drawn = 0.0;
    for (uint32_t i = 0; i < CELLS; i++)
        integral += fixture.cell_values[i].w * fixture.cell_sizes[i];
    for (uint32_t i = 0; i < SAMPLES; i++)
        drawn += is_drawn(&fixture.cell_draws[i]) && fixture.cell_draws[i].weight.w == 0.0f;
    drawn /= SAMPLES;
    assert_true(drawn <= 1.0);
    assert_close(integral, drawn, GRID_EPSILON + SIGMAS * sqrt(drawn * (1.0 - drawn) / SAMPLES));
}

static void density_integrates_to_what_is_drawn(void **state)
{
    device_of(state);
    for_all_cases(check_density, 0.0);
    for_all_cases(check_density, 0.5);
}

// The cell that a direction falls into.
static uint32_t find_bin(const struct bsdf_case *c, const float4 dir)
{
    double pole[3], t[3], b[3], d[3], cross[3];
    vec3_of(d, dir);
    mirrored_view(pole, c);
    frame(t, b, pole);
    vec3_cross(cross, pole, d);
    const double theta = atan2(vec3_length(cross), vec3_dot(pole, d));
    const double turn = atan2(vec3_dot(b, d), vec3_dot(t, d)) / (2.0 * PI);
    const uint32_t ring = (uint32_t)fmin(cbrt(theta / PI) * 16.0, 15.0);
    const uint32_t spoke = (uint32_t)fmin((turn - floor(turn)) * 16.0, 15.0);
    return ring * 16 + spoke;
}

static void check_histogram(enum model model, const struct bsdf_case *c)
{
    double expected[BINS] = {0.0};
    double found[BINS] = {0.0};
    evaluate_sphere(&fixture, model, c);
    draw(&fixture, model, c);
    for (uint32_t i = 0; i < CELLS; i++)
        expected[i / SPOKES * 16 / RINGS * 16 + i % SPOKES * 16 / SPOKES] +=
            fixture.cell_values[i].w * fixture.cell_sizes[i] * SAMPLES;
    for (uint32_t i = 0; i < SAMPLES; i++)
        if (is_drawn(&fixture.cell_draws[i]) && fixture.cell_draws[i].weight.w == 0.0f)
            found[find_bin(c, fixture.cell_draws[i].dir_density)] += 1.0;

    // Each bin by itself: the grid's own error is part of its count.
    for (uint32_t i = 0; i < BINS; i++)
        if (expected[i] >= LEAST_EXPECTED || found[i] >= LEAST_EXPECTED)
            assert_close(found[i], expected[i],
                         SIGMAS * sqrt(fmax(expected[i], LEAST_EXPECTED)) +
                             GRID_EPSILON * SAMPLES / 4.0);
}

static void draws_follow_the_density(void **state)
{
    device_of(state);
    for_all_cases(check_histogram, 0.0);
}

static void check_weights(enum model model, const struct bsdf_case *c)
{
    double n[3], g[3], d[3];
    vec3_of(n, c->normal);
    vec3_of(g, c->geometric);
    draw(&fixture, model, c);
    for (uint32_t i = 0; i < SAMPLES; i++)
        fixture.cell_dirs[i] = fixture.cell_draws[i].dir_density;
    evaluate(&fixture, model, c, fixture.cell_dirs, SAMPLES, fixture.cell_values);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const struct bsdf_draw *draw = &fixture.cell_draws[i];
        const float4 value = fixture.cell_values[i];
        if (!is_drawn(draw) || draw->weight.w != 0.0f)
            continue;
        vec3_of(d, draw->dir_density);
        assert_true(vec3_dot(d, g) > -1e-6 && vec3_dot(d, n) > -1e-6); // rounding of unit vectors
        assert_close(vec3_length(d), 1.0, 1e-6);
        assert_close(draw->dir_density.w, value.w, WEIGHT_EPSILON * value.w + 1e-6);
        assert_close(draw->weight.x * value.w, value.x, WEIGHT_EPSILON * value.x + 1e-6);
    }
}

static void weights_are_values_over_densities(void **state)
{
    device_of(state);
    for_all_cases(check_weights, 0.0);
    for_all_cases(check_weights, 0.5);
}

// Draws and the grid estimate the same reflectance.
static void check_albedo(enum model model, const struct bsdf_case *c)
{
    evaluate_sphere(&fixture, model, c);
    draw(&fixture, model, c);
    double mean = 0.0;
    double squares = 0.0;
    for (uint32_t i = 0; i < SAMPLES; i++) {
        // The grid knows nothing of a mirror.
        const struct bsdf_draw *draw = &fixture.cell_draws[i];
        const double weight = draw->weight.w == 0.0f ? draw->weight.x : 0.0;
        mean += weight / SAMPLES;
        squares += weight * weight / SAMPLES;
    }
    const double sigma = sqrt(fmax(squares - mean * mean, 0.0) / SAMPLES);
    assert_close(mean, grid_albedo(&fixture), GRID_EPSILON + SIGMAS * sigma);
}

static void draws_reflect_what_the_values_do(void **state)
{
    device_of(state);
    for_all_cases(check_albedo, 0.0);
    for_all_cases(check_albedo, 0.5);
}

// A perfect mirror is drawn where nothing else is, and no light sample reaches it.
static void mirrors_reflect_their_colour(void **state)
{
    device_of(state);
    struct bsdf_case c = make_case(0.4, 0.0);
    double pole[3];
    c.material = make_material(0.7f, 1.0f, 0.0f);
    mirrored_view(pole, &c);
    draw(&fixture, MODEL_PHONG, &c);
    evaluate_sphere(&fixture, MODEL_PHONG, &c);
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const struct bsdf_draw *draw = &fixture.cell_draws[i];
        assert_close3(draw->dir_density, pole, 1e-6);
        assert_true(draw->weight.x == 0.7f && draw->weight.w == 1.0f);
        assert_true(draw->dir_density.w == 0.0f);
    }
    for (uint32_t i = 0; i < CELLS; i++)
        assert_true(fixture.cell_values[i].x == 0.0f && fixture.cell_values[i].w == 0.0f);
}

// The cosine rides out of the weight: every draw weighs the colour, exactly.
static void lambert_weighs_its_colour(void **state)
{
    device_of(state);
    for (size_t m = 0; m < COUNT(models); m++) {
        struct bsdf_case c = make_case(0.3, 0.0);
        c.material = make_material(0.6f, 0.0f, 0.5f);
        c.material.specular.w = 0.0f;
        draw(&fixture, models[m], &c);
        for (uint32_t i = 0; i < SAMPLES; i++)
            assert_true(fixture.cell_draws[i].weight.x == 0.6f ||
                        !is_drawn(&fixture.cell_draws[i]));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(density_integrates_to_what_is_drawn),
        cmocka_unit_test(draws_follow_the_density),
        cmocka_unit_test(weights_are_values_over_densities),
        cmocka_unit_test(draws_reflect_what_the_values_do),
        cmocka_unit_test(mirrors_reflect_their_colour),
        cmocka_unit_test(lambert_weighs_its_colour),
    };
    return cmocka_run_group_tests(tests, bsdf_setup, bsdf_teardown);
}
