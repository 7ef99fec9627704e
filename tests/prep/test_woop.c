// Woop's rows against Moeller and Trumbore in double precision.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "prep/woop.h"
#include "prep_support.h"

#define ROUNDS    20000
#define EPSILON   0x1p-22 // the rows are floats: a few of their ulps
#define MIN_SLANT 0.02    // least cosine of a ray and the normal: below, both formulas lose digits

// A family of triangles: corners at org +- size, the third pulled towards the first edge.
struct family {
    double distance; // of the triangle from the origin, m
    double size;     // m
    double sliver;   // height over width; 1: any shape
};

static double apply(const float4 row, const double *p, double w)
{
    return (double)row.x * p[0] + (double)row.y * p[1] + (double)row.z * p[2] + (double)row.w * w;
}

// The sum of the sizes of all terms: what rounding errors are a part of.
static double magnitude(const float4 row, const double *p)
{
    return fabs(row.x * p[0]) + fabs(row.y * p[1]) + fabs(row.z * p[2]) + fabs(row.w);
}

static void make_triangle(float out[3][3], const struct family *family, uint64_t *seed)
{
    double a[3], u[3], v[3];
    for (int k = 0; k < 3; k++) {
        a[k] = family->distance * random_between(seed, 0.5, 1.0);
        u[k] = family->size * random_between(seed, -1.0, 1.0);
        v[k] = family->size * random_between(seed, -1.0, 1.0);
    }
    for (int k = 0; k < 3; k++) {
        out[0][k] = (float)a[k];
        out[1][k] = (float)(a[k] + u[k]);
        out[2][k] = (float)(a[k] + 0.5 * u[k] + family->sliver * v[k]);
    }
}

// Shoots rays at random points of random triangles, and compares.
static void check_family(const struct family *family)
{
    uint64_t seed = 1;
    int compared = 0;
    for (int round = 0; round < ROUNDS; round++) {
        float corners[3][3];
        double wide[3][3], org[3], dir[3], target[3], expected[3];
        make_triangle(corners, family, &seed);
        const double s = random_unit(&seed);
        const double t = random_unit(&seed);
        double length = 0.0;
        for (int k = 0; k < 3; k++) {
            for (int i = 0; i < 3; i++)
                wide[i][k] = corners[i][k];
            target[k] = wide[0][k] + s * (wide[1][k] - wide[0][k]) + t * (wide[2][k] - wide[0][k]);
            org[k] = wide[0][k] + family->size * random_between(&seed, -3.0, 3.0);
            dir[k] = target[k] - org[k];
            length += dir[k] * dir[k];
        }
        for (int k = 0; k < 3; k++)
            dir[k] /= sqrt(length);

        struct woop woop;
        woop_build(&woop, corners[0], corners[1], corners[2]);
        const double dir_w = apply(woop.row_w, dir, 0.0);
        if (!moeller_trumbore(expected, org, dir, wide) || fabs(dir_w) < MIN_SLANT)
            continue;
        compared++;

        // The distance.
        const double found_t = -apply(woop.row_w, org, 1.0) / dir_w;
        const double t_error = EPSILON * magnitude(woop.row_w, org) / fabs(dir_w);
        assert_true(fabs(found_t - expected[0]) <= t_error + EPSILON * fabs(expected[0]));

        // The weights, at the point that the oracle finds.
        double p[3];
        for (int k = 0; k < 3; k++)
            p[k] = org[k] + expected[0] * dir[k];
        assert_true(fabs(apply(woop.row_u, p, 1.0) - expected[1]) <=
                    EPSILON * (1.0 + magnitude(woop.row_u, p)));
        assert_true(fabs(apply(woop.row_v, p, 1.0) - expected[2]) <=
                    EPSILON * (1.0 + magnitude(woop.row_v, p)));
    }
    assert_true(compared > ROUNDS / 2);
}

static void woop_agrees_on_random_triangles(void **state)
{
    (void)state;
    check_family(&(struct family){1.0, 1.0, 1.0});
}

static void woop_agrees_on_slivers(void **state)
{
    (void)state;
    check_family(&(struct family){1.0, 1.0, 1e-3});
}

static void woop_agrees_on_huge_and_tiny_triangles(void **state)
{
    (void)state;
    check_family(&(struct family){1e8, 1e9, 1.0});
    check_family(&(struct family){1e-9, 1e-9, 1.0});
}

static void woop_agrees_far_from_the_origin(void **state)
{
    (void)state;
    check_family(&(struct family){1e5, 10.0, 1.0});
}

static void corners_of_a_triangle_become_those_of_the_unit_triangle(void **state)
{
    (void)state;
    uint64_t seed = 2;
    const struct family family = {10.0, 1.0, 1.0};
    for (int round = 0; round < ROUNDS; round++) {
        float corners[3][3];
        struct woop woop;
        make_triangle(corners, &family, &seed);
        woop_build(&woop, corners[0], corners[1], corners[2]);
        for (int i = 0; i < 3; i++) {
            const double p[3] = {corners[i][0], corners[i][1], corners[i][2]};
            assert_true(fabs(apply(woop.row_u, p, 1.0) - (i == 1)) <=
                        EPSILON * magnitude(woop.row_u, p));
            assert_true(fabs(apply(woop.row_v, p, 1.0) - (i == 2)) <=
                        EPSILON * magnitude(woop.row_v, p));
            assert_true(fabs(apply(woop.row_w, p, 1.0)) <= EPSILON * magnitude(woop.row_w, p));
        }
    }
}

static void degenerate_triangles_have_no_rows(void **state)
{
    (void)state;
    static const float degenerate[][3][3] = {
        {{1, 2, 3}, {1, 2, 3}, {1, 2, 3}},           // a point
        {{1, 2, 3}, {1, 2, 3}, {4, 5, 6}},           // two equal corners
        {{0, 0, 0}, {1, 1, 1}, {2, 2, 2}},           // a line
        {{0, 0, 0}, {1e-44f, 0, 0}, {0, 1e-44f, 0}}, // rows beyond float
    };
    static const struct woop zero;
    for (size_t i = 0; i < sizeof(degenerate) / sizeof(degenerate[0]); i++) {
        struct woop woop;
        woop_build(&woop, degenerate[i][0], degenerate[i][1], degenerate[i][2]);
        assert_memory_equal(&woop, &zero, sizeof(zero));
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(woop_agrees_on_random_triangles),
        cmocka_unit_test(woop_agrees_on_slivers),
        cmocka_unit_test(woop_agrees_on_huge_and_tiny_triangles),
        cmocka_unit_test(woop_agrees_far_from_the_origin),
        cmocka_unit_test(corners_of_a_triangle_become_those_of_the_unit_triangle),
        cmocka_unit_test(degenerate_triangles_have_no_rows),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
