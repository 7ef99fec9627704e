// Walks through the light BVH: they take lights as often as they say, shares of draws sum to one,
// and no light that sends something has none.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "prep/light_fixture.h"
#include "shared/geometry.h"
#include "shared/material.h"
#include "support.h"

#define LIGHTS  300u
#define FEW     8u // that one node has
#define POINTS  400u
#define WALKS   4000u
#define WALKED  50u                    // points that walks start from
#define SLOTS   (LIGHT_WALK_MOST + 1u) // lights of a walk, and the end
#define EPSILON 1e-4                   // of products of float quotients
#define SIGMAS  6.0                    // how far a frequency may be from what is expected

// The lights, their BVH and where they are looked at from, on the device.
struct setup {
    struct gpu *gpu;
    struct program program;
    struct light_fixture fixture;
    struct buffer lights, shapes, nodes, parents, leaves, points, normals;
};

static void open_setup(struct setup *s, void **state, uint32_t light_count)
{
    uint64_t seed = 5;
    float4 points[POINTS], normals[POINTS];
    *s = (struct setup){.gpu = device_of(state)};
    s->program = device_program(s->gpu, "light_bvh", NULL);
    light_fixture_build(&s->fixture, light_count, 5, 4);
    for (uint32_t i = 0; i < light_count; i++) // of surfaces the one triangle there is
        if (i % 5 >= LIGHT_TRIANGLE)
            s->fixture.shapes[i].edge_v.w = bits_to_float(0);
    for (uint32_t i = 0; i < light_count; i++) {
        float4 *u = &s->fixture.shapes[i].edge_u;
        if (i % 5 >= LIGHT_TRIANGLE)
            u->w = 1.0f; // any area will do
    }
    for (int i = 0; i < (int)POINTS; i++) {
        points[i] = random_row(&seed, 22.0);
        normals[i] = random_row(&seed, 1.0);
        const float scale = (float)(1.0 / length_of(normals[i]));
        normals[i].x *= scale;
        normals[i].y *= scale;
        normals[i].z *= scale;
    }
    const struct light_bvh *bvh = &s->fixture.bvh;
    s->lights = device_buffer(s->gpu, s->fixture.lights, light_count * sizeof(struct light));
    s->shapes = device_buffer(s->gpu, s->fixture.shapes, light_count * sizeof(struct light_shape));
    s->nodes = device_buffer(s->gpu, bvh->nodes, bvh->node_count * sizeof(*bvh->nodes));
    s->parents = device_buffer(s->gpu, bvh->parents, bvh->node_count * sizeof(uint32_t));
    s->leaves = device_buffer(s->gpu, bvh->leaves, light_count * sizeof(uint32_t));
    s->points = device_buffer(s->gpu, points, sizeof(points));
    s->normals = device_buffer(s->gpu, normals, sizeof(normals));
}

static void close_setup(struct setup *s)
{
    buffer_free(s->gpu, &s->normals);
    buffer_free(s->gpu, &s->points);
    buffer_free(s->gpu, &s->leaves);
    buffer_free(s->gpu, &s->parents);
    buffer_free(s->gpu, &s->nodes);
    buffer_free(s->gpu, &s->shapes);
    buffer_free(s->gpu, &s->lights);
    light_fixture_free(&s->fixture);
    program_free(&s->program);
}

// Shares of all lights at all points, [POINTS * light_count], for free().
static float *find_shares(struct setup *s, uint32_t light_count)
{
    const uint32_t count = POINTS * light_count;
    float *shares = malloc(count * sizeof(*shares));
    struct buffer out = device_buffer(s->gpu, NULL, count * sizeof(*shares));
    const struct kernel_arg args[] = {
        ARG_BUFFER(&s->nodes),  ARG_BUFFER(&s->parents), ARG_BUFFER(&s->leaves),
        ARG_BUFFER(&s->points), ARG_BUFFER(&s->normals), ARG_VALUE(light_count),
        ARG_BUFFER(&out),       ARG_VALUE(count),
    };
    DEVICE_RUN(s->gpu, &s->program, "light_bvh_shares", args, count);
    assert_ok(buffer_read(s->gpu, &out, shares, count * sizeof(*shares)));
    buffer_free(s->gpu, &out);
    return shares;
}

// Where no child of the root can contribute there are no draws; a walk may also end where a child's
// bounds promise what its own children do not keep: then the sum is below one.
static void shares_sum_to_one_at_most(void **state)
{
    struct setup s;
    open_setup(&s, state, LIGHTS);
    float *shares = find_shares(&s, LIGHTS);
    double mean = 0.0;
    for (uint32_t i = 0; i < POINTS; i++) {
        double sum = 0.0;
        for (uint32_t k = 0; k < LIGHTS; k++)
            sum += shares[i * LIGHTS + k];
        assert_true(sum <= 1.0 + EPSILON);
        mean += sum / POINTS;
    }
    print_message("%.3f of the draws find a light\n", mean);
    assert_true(mean > 0.5);
    free(shares);
    close_setup(&s);
}

// Walks at the first WALKED points, [WALKED * WALKS * SLOTS], for free().
static void find_walks(uint32_t **lights_out, float **expected_out, struct setup *s, float draws)
{
    const uint32_t walks = WALKS;
    const uint32_t count = WALKED * WALKS;
    uint32_t *lights = malloc(count * SLOTS * sizeof(*lights));
    float *expected = malloc(count * SLOTS * sizeof(*expected));
    struct buffer lights_buffer = device_buffer(s->gpu, NULL, count * SLOTS * sizeof(*lights));
    struct buffer expected_buffer = device_buffer(s->gpu, NULL, count * SLOTS * sizeof(*expected));
    const struct kernel_arg args[] = {
        ARG_BUFFER(&s->nodes),
        ARG_BUFFER(&s->points),
        ARG_BUFFER(&s->normals),
        ARG_VALUE(draws),
        ARG_VALUE(walks),
        ARG_BUFFER(&lights_buffer),
        ARG_BUFFER(&expected_buffer),
        ARG_VALUE(count),
    };
    DEVICE_RUN(s->gpu, &s->program, "light_bvh_walks", args, count);
    assert_ok(buffer_read(s->gpu, &lights_buffer, lights, count * SLOTS * sizeof(*lights)));
    assert_ok(buffer_read(s->gpu, &expected_buffer, expected, count * SLOTS * sizeof(*expected)));
    buffer_free(s->gpu, &expected_buffer);
    buffer_free(s->gpu, &lights_buffer);
    *lights_out = lights;
    *expected_out = expected;
}

// Counts how often the walks of one point take each light; none may come twice in one.
static void count_lights(uint32_t *times, const uint32_t *lights, const float *expected,
                         const float *shares, float draws)
{
    memset(times, 0, LIGHTS * sizeof(*times));
    for (uint32_t walk = 0; walk < WALKS; walk++) {
        bool taken[LIGHTS] = {false};
        uint32_t k = 0;
        for (; k < SLOTS && lights[walk * SLOTS + k] != EMITTER_NONE; k++) {
            const uint32_t light = lights[walk * SLOTS + k];
            assert_in_range(light, 0, LIGHTS - 1);
            assert_false(taken[light]);
            taken[light] = true;
            times[light]++;
            const double count = fmin((double)draws * shares[light], 1.0);
            assert_close(expected[walk * SLOTS + k], count, EPSILON * count);
        }
        assert_true(k <= (uint32_t)ceilf(draws));
    }
}

static void walks_take_lights_as_often_as_they_say(void **state)
{
    struct setup s;
    open_setup(&s, state, LIGHTS);
    float *shares = find_shares(&s, LIGHTS);
    const float draws[] = {1.0f, 2.5f, LIGHT_WALK_MOST};
    uint32_t always = 0;
    for (int n = 0; n < 3; n++) {
        uint32_t *lights;
        float *expected;
        find_walks(&lights, &expected, &s, draws[n]);
        for (uint32_t i = 0; i < WALKED; i++) {
            const float *of_point = shares + (size_t)i * LIGHTS;
            const size_t first = (size_t)i * WALKS * SLOTS;
            uint32_t times[LIGHTS];
            count_lights(times, lights + first, expected + first, of_point, draws[n]);
            for (uint32_t light = 0; light < LIGHTS; light++) {
                const double count = (double)draws[n] * of_point[light];
                const double part = fmin(count, 1.0);
                const double sigma = sqrt(part * (1.0 - part) / WALKS) + 1.0 / WALKS;
                assert_close((double)times[light] / WALKS, part, SIGMAS * sigma);
                if (count < 1.0 + EPSILON)
                    continue;
                assert_int_equal(times[light], WALKS);
                always++;
            }
        }
        free(expected);
        free(lights);
    }
    assert_true(always > 10); // enough to mean something
    free(shares);
    close_setup(&s);
}

static void every_light_that_contributes_can_be_drawn(void **state)
{
    struct setup s;
    const uint32_t light_count = LIGHTS;
    const uint32_t count = POINTS * light_count;
    const struct triangle triangle = {0};
    const struct vertex vertex = {0};
    const struct material material = {0};
    open_setup(&s, state, light_count);
    float *shares = find_shares(&s, light_count);
    float *most = malloc(count * sizeof(*most));
    struct buffer triangles = device_buffer(s.gpu, &triangle, sizeof(triangle));
    struct buffer vertices = device_buffer(s.gpu, &vertex, sizeof(vertex));
    struct buffer materials = device_buffer(s.gpu, &material, sizeof(material));
    struct buffer out = device_buffer(s.gpu, NULL, count * sizeof(*most));
    const struct kernel_arg args[] = {
        ARG_BUFFER(&s.lights),  ARG_BUFFER(&s.shapes),  ARG_BUFFER(&triangles),
        ARG_BUFFER(&vertices),  ARG_BUFFER(&materials), ARG_BUFFER(&s.points),
        ARG_BUFFER(&s.normals), ARG_VALUE(light_count), ARG_BUFFER(&out),
        ARG_VALUE(count),
    };
    DEVICE_RUN(s.gpu, &s.program, "light_bvh_contributions", args, count);
    assert_ok(buffer_read(s.gpu, &out, most, count * sizeof(*most)));

    uint32_t lit[5] = {0};
    for (uint32_t i = 0; i < count; i++) {
        if (most[i] > 0.0f && !(shares[i] > 0.0f))
            fail_msg("light %u of type %u sends %g to point %u and is never drawn", i % light_count,
                     i % light_count % 5, (double)most[i], i / light_count);
        lit[i % light_count % 5] += most[i] > 0.0f;
    }
    for (int type = 0; type < 5; type++)
        assert_true(lit[type] > 100); // enough of each to mean something
    buffer_free(s.gpu, &out);
    buffer_free(s.gpu, &materials);
    buffer_free(s.gpu, &vertices);
    buffer_free(s.gpu, &triangles);
    free(most);
    free(shares);
    close_setup(&s);
}

// Kernels for trees of one node say what those for any tree say, bit by bit.
static void few_lights_are_walked_alike_without_loops(void **state)
{
    const struct program_options flat = {.few_lights = true};
    struct setup s;
    uint32_t *lights[2];
    float *expected[2], *shares[2];
    open_setup(&s, state, FEW);
    assert_int_equal(s.fixture.bvh.node_count, 1);
    for (int i = 0; i < 2; i++) {
        shares[i] = find_shares(&s, FEW);
        find_walks(&lights[i], &expected[i], &s, 2.5f);
        program_free(&s.program);
        s.program = device_program(s.gpu, "light_bvh", &flat);
    }
    assert_memory_equal(shares[0], shares[1], POINTS * FEW * sizeof(*shares[0]));
    for (uint32_t walk = 0; walk < WALKED * WALKS; walk++)
        for (uint32_t k = walk * SLOTS;; k++) { // up to the end of each
            assert_int_equal(lights[0][k], lights[1][k]);
            if (lights[0][k] == EMITTER_NONE)
                break;
            assert_memory_equal(&expected[0][k], &expected[1][k], sizeof(expected[0][k]));
        }
    for (int i = 0; i < 2; i++) {
        free(shares[i]);
        free(expected[i]);
        free(lights[i]);
    }
    close_setup(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(shares_sum_to_one_at_most),
        cmocka_unit_test(walks_take_lights_as_often_as_they_say),
        cmocka_unit_test(few_lights_are_walked_alike_without_loops),
        cmocka_unit_test(every_light_that_contributes_can_be_drawn),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
