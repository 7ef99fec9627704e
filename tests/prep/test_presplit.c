// Early split clipping: parts cover their triangle, no part is too big, no box is larger than its
// part.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "prep/presplit.h"
#include "prep_support.h"

#define TRIANGLES 200
#define POINTS    200     // random points on each triangle
#define THRESHOLD 0.5f    // m2
#define EPSILON   0x1p-20 // of a coordinate: a few roundings to float

static double surface(const struct tri_ref *ref)
{
    const double x = ref->hi[0] - ref->lo[0];
    const double y = ref->hi[1] - ref->lo[1];
    const double z = ref->hi[2] - ref->lo[2];
    return 2.0 * (x * y + y * z + z * x);
}

static void corners_of(double out[3][3], const struct geometry *geometry, uint32_t triangle)
{
    for (uint32_t i = 0; i < 3; i++) {
        const float4 row = geometry->vertices[3 * triangle + i].pos_normal;
        out[i][0] = row.x;
        out[i][1] = row.y;
        out[i][2] = row.z;
    }
}

static bool is_inside(const struct tri_ref *ref, const double *p, double slack)
{
    for (int k = 0; k < 3; k++)
        if (p[k] < ref->lo[k] - slack || p[k] > ref->hi[k] + slack)
            return false;
    return true;
}

static void without_a_threshold_each_triangle_has_its_box(void **state)
{
    (void)state;
    struct geometry geometry = make_soup(1, TRIANGLES, 10.0, 3.0);
    struct tri_ref *refs;
    uint32_t count;
    assert_int_equal(presplit(&refs, &count, &geometry, 0.0f), STATUS_OK);
    assert_int_equal(count, TRIANGLES);
    for (uint32_t i = 0; i < count; i++) {
        double p[3][3];
        corners_of(p, &geometry, i);
        assert_int_equal(refs[i].triangle, i);
        for (int k = 0; k < 3; k++) {
            assert_true(refs[i].lo[k] == fmin(p[0][k], fmin(p[1][k], p[2][k])));
            assert_true(refs[i].hi[k] == fmax(p[0][k], fmax(p[1][k], p[2][k])));
        }
    }
    free(refs);
    geometry_free(&geometry);
}

static void parts_cover_every_triangle(void **state)
{
    (void)state;
    struct geometry geometry = make_soup(2, TRIANGLES, 10.0, 3.0);
    struct tri_ref *refs;
    uint32_t count;
    uint64_t seed = 3;
    assert_int_equal(presplit(&refs, &count, &geometry, THRESHOLD), STATUS_OK);
    assert_true(count > TRIANGLES);
    uint32_t first = 0;
    for (uint32_t i = 0; i < TRIANGLES; i++) {
        // A triangle's parts stand side by side.
        uint32_t end = first;
        while (end < count && refs[end].triangle == i)
            end++;

        double p[3][3];
        corners_of(p, &geometry, i);
        for (int j = 0; j < POINTS; j++) {
            double s = random_unit(&seed);
            double t = random_unit(&seed);
            if (s + t > 1.0) {
                s = 1.0 - s;
                t = 1.0 - t;
            }
            double point[3];
            for (int k = 0; k < 3; k++)
                point[k] = p[0][k] + s * (p[1][k] - p[0][k]) + t * (p[2][k] - p[0][k]);
            bool covered = false;
            for (uint32_t part = first; part < end; part++)
                covered = covered || is_inside(&refs[part], point, 0.0);
            assert_true(covered);
        }
        first = end;
    }
    assert_int_equal(first, count);
    free(refs);
    geometry_free(&geometry);
}

static void no_part_is_above_the_threshold(void **state)
{
    (void)state;
    struct geometry geometry = make_soup(4, TRIANGLES, 10.0, 3.0);
    struct tri_ref *refs;
    uint32_t count;
    assert_int_equal(presplit(&refs, &count, &geometry, THRESHOLD), STATUS_OK);
    for (uint32_t i = 0; i < count; i++)
        assert_true(surface(&refs[i]) <= THRESHOLD);
    free(refs);
    geometry_free(&geometry);
}

// ---- the oracle: what a box holds of a triangle is the hull of a few points

struct bounds {
    double lo[3], hi[3];
};

static void take(struct bounds *bounds, const struct tri_ref *ref, const double *p, double slack)
{
    if (!is_inside(ref, p, slack))
        return;
    for (int k = 0; k < 3; k++) {
        bounds->lo[k] = fmin(bounds->lo[k], p[k]);
        bounds->hi[k] = fmax(bounds->hi[k], p[k]);
    }
}

// Corners of the triangle, its edges where they pierce planes of the box, and edges of the box
// where they pierce the triangle.
static struct bounds bound_inside(const struct tri_ref *ref, double p[3][3], double slack)
{
    struct bounds bounds = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (int i = 0; i < 3; i++) {
        const double *a = p[i];
        const double *b = p[(i + 1) % 3];
        take(&bounds, ref, a, slack);
        for (int plane = 0; plane < 6; plane++) {
            const int axis = plane / 2;
            const double at = plane % 2 != 0 ? ref->hi[axis] : ref->lo[axis];
            const double t = (at - a[axis]) / (b[axis] - a[axis]);
            if (!(t >= 0.0 && t <= 1.0))
                continue;
            const double q[3] = {a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1]),
                                 a[2] + t * (b[2] - a[2])};
            take(&bounds, ref, q, slack);
        }
    }
    for (int edge = 0; edge < 12; edge++) {
        const int axis = edge / 4;
        const int i = (axis + 1) % 3;
        const int j = (axis + 2) % 3;
        double org[3], hit[3];
        double dir[3] = {0.0};
        org[axis] = 0.0;
        org[i] = edge % 2 != 0 ? ref->hi[i] : ref->lo[i];
        org[j] = edge / 2 % 2 != 0 ? ref->hi[j] : ref->lo[j];
        dir[axis] = 1.0;
        if (moeller_trumbore(hit, org, dir, p) && hit[1] >= 0.0 && hit[2] >= 0.0 &&
            hit[1] + hit[2] <= 1.0) {
            org[axis] = hit[0];
            take(&bounds, ref, org, slack);
        }
    }
    return bounds;
}

static void boxes_are_as_tight_as_their_parts(void **state)
{
    (void)state;
    const double slack = 10.0 * EPSILON;
    struct geometry geometry = make_soup(5, TRIANGLES, 10.0, 3.0);
    struct tri_ref *refs;
    uint32_t count;
    assert_int_equal(presplit(&refs, &count, &geometry, THRESHOLD), STATUS_OK);
    for (uint32_t i = 0; i < count; i++) {
        double p[3][3];
        corners_of(p, &geometry, refs[i].triangle);
        const struct bounds bounds = bound_inside(&refs[i], p, slack);
        for (int k = 0; k < 3; k++) {
            assert_true(fabs(bounds.lo[k] - refs[i].lo[k]) <= 4.0 * slack);
            assert_true(fabs(bounds.hi[k] - refs[i].hi[k]) <= 4.0 * slack);
        }
    }
    free(refs);
    geometry_free(&geometry);
}

static void degenerate_triangles_get_no_reference(void **state)
{
    (void)state;
    static const float corners[] = {
        1, 2, 3, 1, 2, 3, 1, 2, 3, // a point
        0, 0, 0, 1, 1, 1, 2, 2, 2, // a line
        0, 0, 0, 1, 0, 0, 0, 1, 0, // a triangle
        5, 5, 5, 5, 5, 5, 9, 9, 9, // two equal corners
    };
    struct geometry geometry = make_geometry(corners, 4);
    struct tri_ref *refs;
    uint32_t count;
    assert_int_equal(presplit(&refs, &count, &geometry, 0.01f), STATUS_OK);
    assert_true(count > 1);
    for (uint32_t i = 0; i < count; i++)
        assert_int_equal(refs[i].triangle, 2);
    free(refs);
    geometry_free(&geometry);
}

static void flat_triangles_keep_flat_boxes(void **state)
{
    (void)state;
    static const float corners[] = {-10, 0.3f, -10, 10, 0.3f, -10, 10, 0.3f, 10};
    struct geometry geometry = make_geometry(corners, 1);
    struct tri_ref *refs;
    uint32_t count;
    double area = 0.0;
    assert_int_equal(presplit(&refs, &count, &geometry, THRESHOLD), STATUS_OK);
    for (uint32_t i = 0; i < count; i++) {
        assert_true(refs[i].lo[1] == 0.3f && refs[i].hi[1] == 0.3f);
        area += 0.5 * surface(&refs[i]);
    }
    // The boxes cover the triangle, and at most a row of squares of 0.5 m along its diagonal more.
    assert_true(area >= 200.0 - 1e-6 && area <= 200.0 + 0.5 * 0.25 * 40.0 + 1e-6);
    free(refs);
    geometry_free(&geometry);
}

static void a_threshold_too_small_is_a_limit(void **state)
{
    (void)state;
    struct geometry geometry = make_soup(6, 3, 10.0, 3.0);
    struct tri_ref *refs;
    uint32_t count;
    assert_int_equal(presplit(&refs, &count, &geometry, 1e-12f), STATUS_LIMIT);
    assert_int_equal(presplit(&refs, &count, &geometry, 1e-44f), STATUS_LIMIT);
    assert_non_null(strstr(status_message(), "--split-threshold"));
    geometry_free(&geometry);
}

static void no_triangles_give_no_references(void **state)
{
    (void)state;
    const struct geometry geometry = {0};
    struct tri_ref *refs;
    uint32_t count;
    assert_int_equal(presplit(&refs, &count, &geometry, THRESHOLD), STATUS_OK);
    assert_int_equal(count, 0);
    free(refs);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(without_a_threshold_each_triangle_has_its_box),
        cmocka_unit_test(parts_cover_every_triangle),
        cmocka_unit_test(no_part_is_above_the_threshold),
        cmocka_unit_test(boxes_are_as_tight_as_their_parts),
        cmocka_unit_test(degenerate_triangles_get_no_reference),
        cmocka_unit_test(flat_triangles_keep_flat_boxes),
        cmocka_unit_test(a_threshold_too_small_is_a_limit),
        cmocka_unit_test(no_triangles_give_no_references),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
