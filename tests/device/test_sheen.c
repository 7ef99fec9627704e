// The sheen lobe: the published formulas, symmetric, and no more light than comes.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "bsdf_fixture.h"

#define VALUE_EPSILON 1e-3 // relative: powers up to 100 of a sine's rounding

// A hit of white sheen.
static struct bsdf_case sheen_case(double cosine, double tilt, float roughness)
{
    struct bsdf_case c = make_case(cosine, tilt);
    c.material = make_material(0.5f, 0.0f, 0.5f);
    c.material.sheen = (float4){1.0f, 1.0f, 1.0f, roughness};
    return c;
}

// ---- the oracle: the formulas as they are published, in double precision

static double shadow_log(double x, double alpha)
{
    static const double rough[5] = {21.5473, 3.82987, 0.19823, -1.97760, -4.32054};
    static const double fine[5] = {25.3245, 3.32435, 0.16801, -1.27393, -4.85967};
    const double t = (1.0 - alpha) * (1.0 - alpha);
    double p[5];
    for (int i = 0; i < 5; i++)
        p[i] = (1.0 - t) * rough[i] + t * fine[i];
    return p[0] / (1.0 + p[1] * pow(x, p[2])) + p[3] * x + p[4];
}

static double shadow(double cosine, double alpha)
{
    return cosine < 0.5 ? exp(shadow_log(cosine, alpha))
                        : exp(2.0 * shadow_log(0.5, alpha) - shadow_log(1.0 - cosine, alpha));
}

static double sheen_f(const struct bsdf_case *c, const float4 dir)
{
    double n[3], v[3], l[3], h[3];
    vec3_of(n, c->normal);
    vec3_of(v, c->view);
    vec3_of(l, dir);
    for (int k = 0; k < 3; k++)
        h[k] = l[k] + v[k];
    const double alpha = (double)c->material.sheen.w * c->material.sheen.w;
    const double noh = vec3_dot(n, h) / vec3_length(h);
    const double nol = vec3_dot(n, l);
    const double nov = vec3_dot(n, v);
    const double d = (2.0 + 1.0 / alpha) * pow(fmax(1.0 - noh * noh, 0.0), 0.5 / alpha);
    return d / (2.0 * PI) / (1.0 + shadow(nol, alpha) + shadow(nov, alpha)) / (4.0 * nol * nov);
}

// ---- laws

// From this roughness on the formulas send back less than they get, and nothing is divided.
static void values_are_those_of_the_formulas(void **state)
{
    device_of(state);
    uint64_t seed = 1;
    float4 dirs[DIRS], values[DIRS];
    for (int round = 0; round < 40; round++) {
        const struct bsdf_case c = sheen_case(random_between(&seed, 0.05, 1.0), 0.0,
                                              (float)random_between(&seed, 0.3, 1.0));
        make_dirs(dirs, &c, &seed);
        evaluate(&fixture, MODEL_SHEEN, &c, dirs, DIRS, values);
        for (uint32_t i = 0; i < DIRS; i++) {
            const double expected = sheen_f(&c, dirs[i]) * cosine_of(&c, dirs[i]);
            assert_close(values[i].x, expected, VALUE_EPSILON * expected + 1e-6);
        }
    }
}

static void both_ways_are_the_same(void **state)
{
    device_of(state);
    uint64_t seed = 2;
    float4 dirs[DIRS];
    static const float roughnesses[] = {0.0f, 0.15f, 0.5f, 1.0f};
    for (size_t k = 0; k < COUNT(roughnesses); k++) {
        struct bsdf_case c = sheen_case(0.5, 0.0, roughnesses[k]);
        make_dirs(dirs, &c, &seed);
        check_both_ways(&fixture, MODEL_SHEEN, &c, true, dirs, VALUE_EPSILON, 1e-6);
    }
}

// Calls a check for roughnesses and views.
static void for_all(void (*check)(const struct bsdf_case *c))
{
    static const double cosines[] = {1.0, 0.6, 0.2, 0.05, 0.01};
    static const float roughnesses[] = {0.0f, 0.1f, 0.2f, 0.4f, 0.7f, 1.0f};
    for (size_t i = 0; i < COUNT(cosines); i++)
        for (size_t k = 0; k < COUNT(roughnesses); k++)
            for (int tilted = 0; tilted < 2; tilted++) {
                const struct bsdf_case c = sheen_case(cosines[i], 0.5 * tilted, roughnesses[k]);
                check(&c);
            }
}

static void check_energy(const struct bsdf_case *c)
{
    evaluate_sphere(&fixture, MODEL_SHEEN, c);
    assert_true(grid_albedo(&fixture) <= 1.0 + GRID_EPSILON);
}

static void sheen_sends_back_no_more_than_it_gets(void **state)
{
    device_of(state);
    for_all(check_energy);
}

// The density's integral is the part of draws that end above the surface; draws and the grid
// estimate the same reflectance.
static void check_draws(const struct bsdf_case *c)
{
    double integral = 0.0;
    double drawn = 0.0;
    double mean = 0.0;
    double squares = 0.0;
    evaluate_sphere(&fixture, MODEL_SHEEN, c);
    draw(&fixture, MODEL_SHEEN, c);
    for (uint32_t i = 0; i < CELLS; i++)
        integral += fixture.cell_values[i].w * fixture.cell_sizes[i];
    for (uint32_t i = 0; i < SAMPLES; i++) {
        const struct bsdf_draw *one = &fixture.cell_draws[i];
        drawn += one->dir_density.w > 0.0f ? 1.0 / SAMPLES : 0.0;
        mean += one->weight.x / (double)SAMPLES;
        squares += (double)one->weight.x * one->weight.x / SAMPLES;
    }
    const double sigma = sqrt(fmax(squares - mean * mean, 0.0) / SAMPLES);
    assert_true(drawn <= 1.0 + 1e-9);
    assert_close(integral, drawn, GRID_EPSILON + SIGMAS * sqrt(0.25 / SAMPLES));
    assert_close(mean, grid_albedo(&fixture), GRID_EPSILON + SIGMAS * sigma);
}

static void draws_have_the_density_and_reflect_what_the_values_do(void **state)
{
    device_of(state);
    for_all(check_draws);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_those_of_the_formulas),
        cmocka_unit_test(both_ways_are_the_same),
        cmocka_unit_test(sheen_sends_back_no_more_than_it_gets),
        cmocka_unit_test(draws_have_the_density_and_reflect_what_the_values_do),
    };
    return cmocka_run_group_tests(tests, bsdf_setup, bsdf_teardown);
}
