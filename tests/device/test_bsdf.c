// The BSDFs' values: those of the formulas, symmetric, and no more light than comes.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "bsdf_fixture.h"

#define VALUE_EPSILON 3e-4 // relative: the lobes' powers multiply a cosine's rounding by up to 250
#define LAMBERT_ERROR 1e-3 // of the grid where there is no edge: the cosine ends the horizon softly
#define ROUNDS        60

// ---- the oracle: the formulas as they are published, in double precision

static double fifth_power(double x)
{
    return x * x * x * x * x;
}

static double mix(double a, double b, double share)
{
    return a + (b - a) * share;
}

// The microfacet lobe without its Fresnel term, V D (glTF 2.0, appendix B.3.2).
static double ggx_lobe(double alpha, double nol, double nov, double noh)
{
    const double a2 = alpha * alpha;
    const double f = noh * noh * (a2 - 1.0) + 1.0;
    const double d = a2 / (PI * f * f);
    const double sl = nol + sqrt(a2 + (1.0 - a2) * nol * nol);
    const double sv = nov + sqrt(a2 + (1.0 - a2) * nov * nov);
    return d / (sl * sv);
}

// f of a grey metallic-roughness material with KHR_materials_specular (appendix B.2 and B.3).
static double gltf_f(const struct material *m, double nol, double nov, double noh, double voh)
{
    const double alpha = fmax((double)m->roughness * m->roughness, 1e-3);
    const double grazing = fifth_power(1.0 - voh);
    const double strength = m->specular.w;
    const double f0 = fmin(0.04 * m->specular.x, 1.0) * strength;
    const double fresnel = f0 + (strength - f0) * grazing;
    const double lobe = ggx_lobe(alpha, nol, nov, noh);
    const double dielectric = m->base.x / PI * (1.0 - fresnel) + fresnel * lobe;
    const double metal = (m->base.x + (1.0 - m->base.x) * grazing) * lobe;
    return mix(dielectric, metal, m->metallic);
}

// f of a grey material of KHR_materials_pbrSpecularGlossiness.
static double glossiness_f(const struct material *m, double nol, double nov, double noh, double voh)
{
    const double alpha = fmax((1.0 - m->glossiness) * (1.0 - m->glossiness), 1e-3);
    const double f0 = m->specular.x;
    const double fresnel = f0 + (1.0 - f0) * fifth_power(1.0 - voh);
    const double diffuse = m->base.x * (1.0 - f0);
    return diffuse / PI * (1.0 - fresnel) + fresnel * ggx_lobe(alpha, nol, nov, noh);
}

// f of the thesis's model, A.1.2, with its lobe normalised by (n + 1) / (2 pi).
static double phong_f(const struct material *m, double nol, double cos_lobe)
{
    const bool glossy = (m->flags & MATERIAL_SPECULAR_GLOSSINESS) != 0;
    const double roughness = glossy ? 1.0 - m->glossiness : m->roughness;
    const double exponent = 2.0 / pow(roughness, 4.0) - 2.0;
    const double diffuse = glossy ? m->base.x : m->base.x * (1.0 - m->metallic);
    const double f0 =
        glossy ? m->specular.x
               : mix(fmin(0.04 * m->specular.x, 1.0) * m->specular.w, m->base.x, m->metallic);
    const double lobe = (exponent + 1.0) / (2.0 * PI) * pow(fmax(cos_lobe, 0.0), exponent);
    return diffuse / PI + f0 * lobe / nol;
}

static double oracle_f(enum model model, const struct bsdf_case *c, const float4 dir)
{
    double n[3], v[3], l[3], h[3], mirrored[3];
    vec3_of(n, c->normal);
    vec3_of(v, c->view);
    vec3_of(l, dir);
    mirrored_view(mirrored, c);
    for (int k = 0; k < 3; k++)
        h[k] = l[k] + v[k];
    const double length = vec3_length(h);
    const double nol = vec3_dot(n, l);
    if (model == MODEL_PHONG)
        return phong_f(&c->material, nol, vec3_dot(mirrored, l));
    const double nov = vec3_dot(n, v);
    const double noh = vec3_dot(n, h) / length;
    const double voh = vec3_dot(v, h) / length;
    return (c->material.flags & MATERIAL_SPECULAR_GLOSSINESS)
               ? glossiness_f(&c->material, nol, nov, noh, voh)
               : gltf_f(&c->material, nol, nov, noh, voh);
}

// ---- laws

// A material of either workflow, not so smooth that a cosine's rounding shows.
static struct material random_material(uint64_t *seed)
{
    struct material m = make_material((float)random_unit(seed), (float)random_unit(seed),
                                      (float)random_between(seed, 0.3, 1.0));
    m.glossiness = 1.0f - m.roughness;
    m.specular.w = (float)random_unit(seed);
    m.specular.x = m.specular.y = m.specular.z = (float)random_between(seed, 0.05, 1.0);
    m.flags = random_unit(seed) < 0.3 ? MATERIAL_SPECULAR_GLOSSINESS : 0;
    return m;
}

static void values_are_those_of_the_formulas(void **state)
{
    device_of(state);
    uint64_t seed = 1;
    float4 dirs[DIRS], values[DIRS];
    for (int round = 0; round < ROUNDS; round++) {
        const enum model model = models[round % COUNT(models)];
        struct bsdf_case c = make_case(random_between(&seed, 0.05, 1.0), 0.0);
        c.material = random_material(&seed);
        make_dirs(dirs, &c, &seed);
        evaluate(&fixture, model, &c, dirs, DIRS, values);
        for (uint32_t i = 0; i < DIRS; i++) {
            const double expected = oracle_f(model, &c, dirs[i]) * cosine_of(&c, dirs[i]);
            assert_close(values[i].x, expected, VALUE_EPSILON * expected + 1e-7);
        }
    }
}

// f(a, b) = f(b, a). The thesis's lobe is divided by the light's cosine alone, so of it f cos is
// symmetric instead.
static void both_ways_are_the_same(void **state)
{
    device_of(state);
    uint64_t seed = 2;
    float4 dirs[DIRS];
    for (int round = 0; round < 6; round++) {
        const enum model model = models[round % COUNT(models)];
        struct bsdf_case c = make_case(0.5, 0.0);
        c.material = random_material(&seed);
        if (model == MODEL_PHONG) {
            c.material.metallic = 1.0f; // no diffuse part
            c.material.flags = 0;
        }
        make_dirs(dirs, &c, &seed);
        check_both_ways(&fixture, model, &c, model != MODEL_PHONG, dirs, VALUE_EPSILON, 1e-7);
    }
}

static void nothing_comes_from_below(void **state)
{
    device_of(state);
    for (size_t m = 0; m < COUNT(models); m++) {
        struct bsdf_case c = make_case(0.5, 0.5);
        double g[3], n[3], d[3];
        vec3_of(g, c.geometric);
        vec3_of(n, c.normal);
        c.material = make_material(0.8f, 0.5f, 0.5f);
        evaluate_sphere(&fixture, models[m], &c);
        for (uint32_t i = 0; i < CELLS; i++) {
            vec3_of(d, fixture.cell_dirs[i]);
            const float4 value = fixture.cell_values[i];
            if (vec3_dot(g, d) < -1e-6 || vec3_dot(n, d) < -1e-6) // rounding of unit vectors
                assert_true(value.x == 0.0f && value.w == 0.0f);
            else if (vec3_dot(g, d) > 1e-6 && vec3_dot(n, d) > 1e-6)
                assert_true(value.x > 0.0f && value.w > 0.0f);
        }
    }
}

// A white Lambert surface in a white furnace cannot be seen.
static void white_lambert_reflects_all(void **state)
{
    device_of(state);
    for (size_t m = 0; m < COUNT(models); m++) {
        struct bsdf_case c = make_case(0.3, 0.0);
        c.material = make_material(1.0f, 0.0f, 0.5f);
        c.material.specular.w = 0.0f;
        evaluate_sphere(&fixture, models[m], &c);
        assert_close(grid_albedo(&fixture), 1.0, LAMBERT_ERROR);
    }
}

// A microfacet surface loses what would bounce twice, more the rougher it is; a smooth one nothing.
static void white_metal_loses_light_by_roughness(void **state)
{
    device_of(state);
    static const float roughnesses[] = {0.03f, 0.1f, 0.2f, 0.4f, 0.6f, 0.8f, 1.0f};
    for (int view = 0; view < 3; view++) {
        double last = 1.0;
        for (size_t i = 0; i < COUNT(roughnesses); i++) {
            struct bsdf_case c = make_case(1.0 - 0.3 * view, 0.0);
            c.material = make_material(1.0f, 1.0f, roughnesses[i]);
            evaluate_sphere(&fixture, false, &c);
            const double albedo = grid_albedo(&fixture);
            assert_true(albedo <= last + GRID_EPSILON);
            if (i == 0)
                assert_close(albedo, 1.0, GRID_EPSILON);
            last = albedo;
        }
    }
}

// Of dielectrics, appendix B bounds this only where neither direction grazes: it weighs the base by
// the half vector's Fresnel term, which is small for light from above even where the view grazes
// and the coat reflects nearly all.
static void check_energy(enum model model, const struct bsdf_case *c)
{
    const bool grazes = cosine_of(c, c->view) < 0.5;
    if (model != MODEL_PHONG && c->material.metallic < 1.0f && grazes)
        return;
    evaluate_sphere(&fixture, model, c);
    assert_true(grid_albedo(&fixture) <= 1.0 + GRID_EPSILON);
}

static void no_surface_reflects_more_than_it_gets(void **state)
{
    device_of(state);
    for_all_cases(check_energy, 0.0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(values_are_those_of_the_formulas),
        cmocka_unit_test(both_ways_are_the_same),
        cmocka_unit_test(nothing_comes_from_below),
        cmocka_unit_test(white_lambert_reflects_all),
        cmocka_unit_test(white_metal_loses_light_by_roughness),
        cmocka_unit_test(no_surface_reflects_more_than_it_gets),
    };
    return cmocka_run_group_tests(tests, bsdf_setup, bsdf_teardown);
}
