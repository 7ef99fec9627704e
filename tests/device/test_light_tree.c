// Drawing lights on the device: probabilities are the host's, and what is drawn follows them.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "prep/light_tree.h"
#include "prep/prep_support.h"
#include "shared/geometry.h"
#include "support.h"

#define DRAWS       (1u << 16)
#define POINTS      12
#define PMF_EPSILON 1e-5 // relative: products of up to 30 floats
#define SIGMAS      6.0  // how far a frequency may be from its probability

// A kind of light tree.
struct kind {
    uint32_t count;
    uint32_t unranged; // every so manieth light reaches everywhere; 0: none
    double range;      // m, of the others at most
    double power_skew; // exponent of ten that powers span
};

static const struct kind kinds[] = {
    {1, 0, 5.0, 1.0},   {1, 1, 0.0, 1.0},   {2, 1, 0.0, 1.0},
    {2, 2, 30.0, 1.0},  {300, 0, 5.0, 1.0}, {300, 0, 40.0, 1.0},
    {300, 1, 0.0, 3.0}, {300, 3, 8.0, 1.0}, {4000, 1, 0.0, 2.0},
};

#define KIND_COUNT (sizeof(kinds) / sizeof(kinds[0]))

struct fixture {
    struct gpu *gpu;
    struct program program;
    const struct kind *kind;
    struct light *lights;
    float *power;
    struct light_tree tree;
    struct buffer nodes, parents, leaves;
    uint32_t *bits; // [DRAWS] random
    struct buffer bits_buffer;
    uint64_t seed;
};

static void make_fixture(struct fixture *f, struct gpu *gpu, const struct kind *kind)
{
    *f = (struct fixture){.gpu = gpu, .kind = kind, .seed = 1};
    f->program = device_program(gpu, "light", NULL);
    f->lights = calloc(kind->count, sizeof(*f->lights));
    f->power = calloc(kind->count, sizeof(*f->power));
    for (uint32_t i = 0; i < kind->count; i++) {
        const bool far = kind->unranged > 0 && i % kind->unranged == 0;
        float *org = &f->lights[i].org_range.x;
        for (int k = 0; k < 3; k++)
            org[k] = (float)random_between(&f->seed, -10.0, 10.0);
        org[3] = far ? LIGHT_NO_RANGE : (float)(kind->range * random_between(&f->seed, 0.1, 1.0));
        f->power[i] = (float)pow(10.0, kind->power_skew * random_unit(&f->seed));
    }
    assert_ok(light_tree_build(&f->tree, f->lights, NULL, f->power, kind->count));
    f->nodes = device_buffer(gpu, f->tree.nodes, f->tree.node_count * sizeof(*f->tree.nodes));
    f->parents = device_buffer(gpu, f->tree.parents, f->tree.node_count * sizeof(uint32_t));
    f->leaves = device_buffer(gpu, f->tree.leaves, kind->count * sizeof(uint32_t));
    f->bits = malloc(DRAWS * sizeof(*f->bits));
    for (uint32_t i = 0; i < DRAWS; i++)
        f->bits[i] = (uint32_t)(random_unit(&f->seed) * 0x1p32);
    f->bits_buffer = device_buffer(gpu, f->bits, DRAWS * sizeof(*f->bits));
}

static void release(struct fixture *f)
{
    buffer_free(f->gpu, &f->bits_buffer);
    free(f->bits);
    buffer_free(f->gpu, &f->leaves);
    buffer_free(f->gpu, &f->parents);
    buffer_free(f->gpu, &f->nodes);
    light_tree_free(&f->tree);
    free(f->power);
    free(f->lights);
    program_free(&f->program);
}

// Probabilities of all lights at p, as the device has them; released with free().
static float *device_pmfs(const struct fixture *f, float4 p)
{
    const uint32_t count = f->kind->count;
    float *pmfs = malloc(count * sizeof(*pmfs));
    struct buffer out = device_buffer(f->gpu, NULL, count * sizeof(*pmfs));
    const struct kernel_arg args[] = {ARG_BUFFER(&f->nodes),  ARG_BUFFER(&f->parents),
                                      ARG_BUFFER(&f->leaves), ARG_VALUE(p),
                                      ARG_VALUE(count),       ARG_BUFFER(&out)};
    DEVICE_RUN(f->gpu, &f->program, "light_pmfs", args, count);
    assert_ok(buffer_read(f->gpu, &out, pmfs, count * sizeof(*pmfs)));
    buffer_free(f->gpu, &out);
    return pmfs;
}

// Draws DRAWS lights at p, with the probability that each draw claims.
static void device_draws(const struct fixture *f, float4 p, uint32_t *lights, float *pmfs)
{
    const uint32_t count = DRAWS;
    struct buffer lights_buffer = device_buffer(f->gpu, NULL, DRAWS * sizeof(*lights));
    struct buffer pmfs_buffer = device_buffer(f->gpu, NULL, DRAWS * sizeof(*pmfs));
    const struct kernel_arg args[] = {ARG_BUFFER(&f->nodes),       ARG_VALUE(p),
                                      ARG_BUFFER(&f->bits_buffer), ARG_VALUE(count),
                                      ARG_BUFFER(&lights_buffer),  ARG_BUFFER(&pmfs_buffer)};
    DEVICE_RUN(f->gpu, &f->program, "light_draws", args, count);
    assert_ok(buffer_read(f->gpu, &lights_buffer, lights, DRAWS * sizeof(*lights)));
    assert_ok(buffer_read(f->gpu, &pmfs_buffer, pmfs, DRAWS * sizeof(*pmfs)));
    buffer_free(f->gpu, &pmfs_buffer);
    buffer_free(f->gpu, &lights_buffer);
}

static float4 random_point(uint64_t *seed)
{
    return (float4){(float)random_between(seed, -13.0, 13.0),
                    (float)random_between(seed, -13.0, 13.0),
                    (float)random_between(seed, -13.0, 13.0), 0.0f};
}

// ---- laws

static void check_pmfs(struct fixture *f)
{
    for (int i = 0; i < POINTS; i++) {
        const float4 p = random_point(&f->seed);
        float *pmfs = device_pmfs(f, p);
        for (uint32_t light = 0; light < f->kind->count; light++) {
            const double host = light_tree_pmf(&f->tree, &p.x, light);
            assert_close(pmfs[light], host, PMF_EPSILON * host);

            // Every light that reaches the point can be drawn.
            const float4 l = f->lights[light].org_range;
            const double d2 =
                (l.x - p.x) * (l.x - p.x) + (l.y - p.y) * (l.y - p.y) + (l.z - p.z) * (l.z - p.z);
            if (l.w == LIGHT_NO_RANGE || sqrt(d2) < l.w)
                assert_true(pmfs[light] > 0.0f);
        }
        free(pmfs);
    }
}

static void pmfs_are_the_hosts(void **state)
{
    for (size_t i = 0; i < KIND_COUNT; i++) {
        struct fixture f;
        make_fixture(&f, device_of(state), &kinds[i]);
        check_pmfs(&f);
        release(&f);
    }
}

static void check_draws(struct fixture *f, float4 p)
{
    float *pmfs = device_pmfs(f, p);
    uint32_t *lights = malloc(DRAWS * sizeof(*lights));
    float *claims = malloc(DRAWS * sizeof(*claims));
    uint32_t *counts = calloc(f->kind->count, sizeof(*counts));
    uint32_t none = 0;
    double sum = 0.0;
    device_draws(f, p, lights, claims);
    for (uint32_t i = 0; i < DRAWS; i++) {
        if (lights[i] == EMITTER_NONE) {
            none++;
            continue;
        }
        assert_true(lights[i] < f->kind->count);
        assert_close(claims[i], pmfs[lights[i]], PMF_EPSILON * pmfs[lights[i]]);
        counts[lights[i]]++;
    }
    double chi_square = 0.0;
    uint32_t bins = 0;
    for (uint32_t i = 0; i < f->kind->count; i++) {
        const double expected = (double)pmfs[i] * DRAWS;
        sum += pmfs[i];
        if (expected == 0.0)
            assert_int_equal(counts[i], 0);
        if (expected < 5.0) // too few for chi-square
            continue;
        chi_square += (counts[i] - expected) * (counts[i] - expected) / expected;
        bins++;
    }
    assert_true(chi_square < bins + SIGMAS * sqrt(2.0 * bins) + SIGMAS * SIGMAS);
    assert_close(none, (1.0 - sum) * DRAWS,
                 SIGMAS * sqrt(fmax(sum * (1.0 - sum), 0.0) * DRAWS) + PMF_EPSILON * DRAWS);
    free(counts);
    free(claims);
    free(lights);
    free(pmfs);
}

static void draws_follow_the_pmf(void **state)
{
    for (size_t i = 0; i < KIND_COUNT; i++) {
        struct fixture f;
        make_fixture(&f, device_of(state), &kinds[i]);
        for (int k = 0; k < POINTS; k++)
            check_draws(&f, random_point(&f.seed));
        release(&f);
    }
}

static void nothing_is_drawn_out_of_reach(void **state)
{
    struct fixture f;
    static const struct kind kind = {50, 0, 5.0, 1.0};
    make_fixture(&f, device_of(state), &kind);
    uint32_t *lights = malloc(DRAWS * sizeof(*lights));
    float *claims = malloc(DRAWS * sizeof(*claims));
    device_draws(&f, (float4){100.0f, 0.0f, 0.0f, 0.0f}, lights, claims);
    for (uint32_t i = 0; i < DRAWS; i++)
        assert_int_equal(lights[i], EMITTER_NONE);
    free(claims);
    free(lights);
    release(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pmfs_are_the_hosts),
        cmocka_unit_test(draws_follow_the_pmf),
        cmocka_unit_test(nothing_is_drawn_out_of_reach),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
