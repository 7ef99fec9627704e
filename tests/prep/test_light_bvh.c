// The light BVH: every light stands in it once, and every node's bounds hold what is below.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "light_fixture.h"

#define EPSILON  1e-4 // m, of places up to 20 m away
#define MANY     1000000u
#define MOST     128.0 // bytes a light may take
#define LEVELS   64
#define PER_TYPE 200u

static float cell(const struct light_bvh *bvh, uint32_t node, int row, uint32_t child)
{
    return ((const float *)&bvh->nodes[node])[row * 8 + (int)child];
}

static uint word_of(const struct light_bvh *bvh, uint32_t node, uint32_t child)
{
    return float_to_bits(cell(bvh, node, 11, child));
}

static uint type_of(const struct light *light)
{
    return float_to_bits(light->color_kind.w) & LIGHT_TYPE_MASK;
}

// The unit axis of what is no point; for point lights none.
static void axis_of(double *out, const struct light *light, const struct light_shape *shape)
{
    const float4 u = shape->edge_u;
    const float4 v = shape->edge_v;
    if (type_of(light) == LIGHT_SPOT) {
        out[0] = u.x;
        out[1] = u.y;
        out[2] = u.z;
        return;
    }
    out[0] = (double)u.y * v.z - (double)u.z * v.y;
    out[1] = (double)u.z * v.x - (double)u.x * v.z;
    out[2] = (double)u.x * v.y - (double)u.y * v.x;
    const double length = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]);
    for (int k = 0; k < 3; k++)
        out[k] /= length;
}

// Points at the rim of a light: all of it lies between them, or within EPSILON of that.
static int rim_of(double out[32][3], const struct light *light, const struct light_shape *shape)
{
    static const double triangle[][2] = {{0, 0}, {1, 0}, {0, 1}};
    static const double square[][2] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    const uint type = type_of(light);
    const int count = type == LIGHT_TRIANGLE    ? 3
                      : type == LIGHT_RECTANGLE ? 4
                      : type == LIGHT_DISC      ? 32
                                                : 1;
    const float4 org = light->org_range;
    for (int i = 0; i < count; i++) {
        double s = 0.0;
        double t = 0.0;
        if (type == LIGHT_TRIANGLE || type == LIGHT_RECTANGLE) {
            s = count == 3 ? triangle[i][0] : square[i][0];
            t = count == 3 ? triangle[i][1] : square[i][1];
        } else if (type == LIGHT_DISC) {
            s = cos(i * M_PI / 16.0);
            t = sin(i * M_PI / 16.0);
        }
        out[i][0] = org.x + s * shape->edge_u.x + t * shape->edge_v.x;
        out[i][1] = org.y + s * shape->edge_u.y + t * shape->edge_v.y;
        out[i][2] = org.z + s * shape->edge_u.z + t * shape->edge_v.z;
    }
    return count;
}

// ---- laws

static void every_light_stands_in_one_leaf(void **state)
{
    (void)state;
    const uint32_t counts[] = {1, 2, 7, 8, 9, 100, 3000};
    for (int i = 0; i < 7; i++) {
        struct light_fixture fixture;
        light_fixture_build(&fixture, counts[i], 5, 1);
        const struct light_bvh *bvh = &fixture.bvh;
        uint32_t *seen = calloc(counts[i], sizeof(*seen));
        uint32_t leaves = 0;
        for (uint32_t node = 0; node < bvh->node_count; node++) {
            for (uint32_t child = 0; child < 8; child++) {
                const uint word = word_of(bvh, node, child);
                if (word == LIGHT_BVH_EMPTY) {
                    assert_true(cell(bvh, node, 4, child) == 0.0f);
                } else if (word & LIGHT_BVH_LEAF) {
                    assert_in_range(word & ~LIGHT_BVH_LEAF, 0, counts[i] - 1);
                    seen[word & ~LIGHT_BVH_LEAF]++;
                    assert_int_equal(bvh->leaves[word & ~LIGHT_BVH_LEAF], node << 3 | child);
                    leaves++;
                } else {
                    assert_in_range(word, node + 1, bvh->node_count - 1);
                    assert_int_equal(bvh->parents[word], node << 3 | child);
                }
            }
        }
        assert_int_equal(bvh->parents[0], LIGHT_BVH_ROOT);
        assert_int_equal(leaves, counts[i]);
        for (uint32_t light = 0; light < counts[i]; light++)
            assert_int_equal(seen[light], 1);
        free(seen);
        light_fixture_free(&fixture);
    }
}

// Checks that one child's bounds hold one light below it.
static void check_held(const struct light_fixture *fixture, uint32_t place, uint32_t index)
{
    const struct light_bvh *bvh = &fixture->bvh;
    const uint32_t node = place >> 3;
    const uint32_t child = place & 7u;
    const struct light *light = &fixture->lights[index];
    const struct light_shape *shape = &fixture->shapes[index];
    const uint kind = float_to_bits(light->color_kind.w);

    // Its place: within the sphere.
    double rim[32][3];
    const int rim_count = rim_of(rim, light, shape);
    for (int i = 0; i < rim_count; i++) {
        double distance2 = 0.0;
        for (int k = 0; k < 3; k++) {
            const double d = rim[i][k] - cell(bvh, node, k, child);
            distance2 += d * d;
        }
        assert_true(sqrt(distance2) <= cell(bvh, node, 3, child) + EPSILON);
    }

    // Its range and power: no more than the bounds'.
    const float range = light->org_range.w;
    assert_true(cell(bvh, node, 5, child) >= (range > 0.0f ? range : FLT_MAX));
    const double power = fabs((double)cell(bvh, node, 4, child));
    if (type_of(light) <= LIGHT_SPOT)
        assert_true(power >= 0.9999 * light->color_kind.x);
    if (kind & LIGHT_TWO_SIDED)
        assert_true(cell(bvh, node, 4, child) < 0.0f);

    // Its directions: within the cone.
    const double cos_o = cell(bvh, node, 9, child);
    const double cos_e = cell(bvh, node, 10, child);
    if (type_of(light) == LIGHT_POINT) {
        assert_true(cos_o <= -1.0 + 1e-6);
        return;
    }
    double axis[3], cosine = 0.0;
    axis_of(axis, light, shape);
    for (int k = 0; k < 3; k++)
        cosine += axis[k] * cell(bvh, node, 6 + k, child);
    cosine = kind & LIGHT_TWO_SIDED ? fabs(cosine) : cosine;
    assert_true(cosine >= cos_o - 1e-6);
    const double widest =
        type_of(light) == LIGHT_SPOT ? -(double)shape->edge_v.w / shape->edge_u.w : 0.0;
    assert_true(cos_e <= widest);
}

static void bounds_hold_every_light_below(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed <= 5; seed++) {
        struct light_fixture fixture;
        light_fixture_build(&fixture, 5 * PER_TYPE, seed == 5 ? 1 : 5, seed);
        for (uint32_t light = 0; light < fixture.count; light++) {
            uint32_t place = fixture.bvh.leaves[light];
            for (int level = 0; place != LIGHT_BVH_ROOT; level++) {
                assert_true(level < LEVELS);
                check_held(&fixture, place, light);
                place = fixture.bvh.parents[place >> 3];
            }
        }
        light_fixture_free(&fixture);
    }
}

static void power_is_the_sum_of_what_is_below(void **state)
{
    (void)state;
    struct light_fixture fixture;
    light_fixture_build(&fixture, 3000, 5, 9);
    const struct light_bvh *bvh = &fixture.bvh;
    for (uint32_t node = 1; node < bvh->node_count; node++) {
        const uint32_t place = bvh->parents[node];
        double sum = 0.0;
        for (uint32_t child = 0; child < 8; child++)
            sum += fabs((double)cell(bvh, node, 4, child));
        const double whole = fabs((double)cell(bvh, place >> 3, 4, place & 7u));
        assert_true(fabs(sum - whole) <= 1e-5 * whole);
    }
    light_fixture_free(&fixture);
}

// Lights in one place cannot be told apart: the depth must stay bounded all the same.
static void heaps_and_rows_of_lights_do_not_make_a_list(void **state)
{
    (void)state;
    for (int row = 0; row < 2; row++) {
        struct light_fixture fixture = {.count = 20000};
        fixture.lights = calloc(fixture.count, sizeof(*fixture.lights));
        fixture.power = calloc(fixture.count, sizeof(*fixture.power));
        for (uint32_t i = 0; i < fixture.count; i++) {
            fixture.lights[i].org_range.x = row ? (float)i : 3.0f;
            fixture.lights[i].color_kind = (float4){1.0f, 1.0f, 1.0f, 0.0f};
            fixture.power[i] = 12.0f;
        }
        assert_int_equal(
            light_bvh_build(&fixture.bvh, fixture.lights, NULL, fixture.power, fixture.count),
            STATUS_OK);
        for (uint32_t light = 0; light < fixture.count; light++) {
            int level = 0;
            for (uint32_t place = fixture.bvh.leaves[light]; place != LIGHT_BVH_ROOT; level++)
                place = fixture.bvh.parents[place >> 3];
            assert_true(level <= 12); // 20000 lights fill five levels of eight
        }
        light_fixture_free(&fixture);
    }
}

static void a_million_lights_take_few_bytes_each(void **state)
{
    (void)state;
    static const char *const names[] = {"points", "points and spots", "all types"};
    const uint types[] = {1, 2, 5};
    for (int i = 0; i < 3; i++) {
        struct light_fixture fixture;
        const double start_s = clock_seconds();
        light_fixture_build(&fixture, MANY, types[i], 3);
        const double seconds = clock_seconds() - start_s;
        const double bytes = (double)sizeof(struct light) + sizeof(*fixture.bvh.leaves) +
                             (double)fixture.bvh.node_count *
                                 (sizeof(*fixture.bvh.nodes) + sizeof(*fixture.bvh.parents)) / MANY;
        double levels = 0.0; // of an average light
        for (uint32_t light = 0; light < MANY; light++)
            for (uint32_t at = fixture.bvh.leaves[light]; at != LIGHT_BVH_ROOT;
                 at = fixture.bvh.parents[at >> 3])
                levels += 1.0 / MANY;
        print_message("%s: a million in %.2f s, %.1f bytes each, %.2f levels\n", names[i], seconds,
                      bytes, levels);
        assert_true(bytes < MOST);
        light_fixture_free(&fixture);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_light_stands_in_one_leaf),
        cmocka_unit_test(bounds_hold_every_light_below),
        cmocka_unit_test(power_is_the_sum_of_what_is_below),
        cmocka_unit_test(heaps_and_rows_of_lights_do_not_make_a_list),
        cmocka_unit_test(a_million_lights_take_few_bytes_each),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
