// Drawing from the light BVH: probabilities are those of the draws, they sum to one, and no light
// that sends something has none.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdlib.h>

#include "prep/light_fixture.h"
#include "shared/geometry.h"
#include "shared/material.h"
#include "support.h"

#define LIGHTS  300u
#define POINTS  400u
#define DRAWS   4000u
#define EPSILON 1e-4 // of products of float quotients
#define SIGMAS  6.0  // how far a frequency may be from its probability

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

// Probabilities of all lights at all points, [POINTS * light_count], for free().
static float *find_pmfs(struct setup *s, uint32_t light_count)
{
    const uint32_t count = POINTS * light_count;
    float *pmfs = malloc(count * sizeof(*pmfs));
    struct buffer out = device_buffer(s->gpu, NULL, count * sizeof(*pmfs));
    const struct kernel_arg args[] = {
        ARG_BUFFER(&s->nodes),  ARG_BUFFER(&s->parents), ARG_BUFFER(&s->leaves),
        ARG_BUFFER(&s->points), ARG_BUFFER(&s->normals), ARG_VALUE(light_count),
        ARG_BUFFER(&out),       ARG_VALUE(count),
    };
    DEVICE_RUN(s->gpu, &s->program, "light_bvh_pmfs", args, count);
    assert_ok(buffer_read(s->gpu, &out, pmfs, count * sizeof(*pmfs)));
    buffer_free(s->gpu, &out);
    return pmfs;
}

// A point where no child of the root can contribute has no draws; a descent may also end where a
// child's bounds promise what its own children do not keep: then the sum is below one.
static void pmfs_sum_to_one_at_most(void **state)
{
    struct setup s;
    open_setup(&s, state, LIGHTS);
    float *pmfs = find_pmfs(&s, LIGHTS);
    double mean = 0.0;
    for (uint32_t i = 0; i < POINTS; i++) {
        double sum = 0.0;
        for (uint32_t k = 0; k < LIGHTS; k++)
            sum += pmfs[i * LIGHTS + k];
        assert_true(sum <= 1.0 + EPSILON);
        mean += sum / POINTS;
    }
    print_message("%.3f of the draws find a light\n", mean);
    assert_true(mean > 0.5);
    free(pmfs);
    close_setup(&s);
}

static void draws_follow_their_pmf(void **state)
{
    struct setup s;
    open_setup(&s, state, LIGHTS);
    float *pmfs = find_pmfs(&s, LIGHTS);
    const uint32_t points = 50;
    const uint32_t draws = DRAWS;
    const uint32_t count = points * draws;
    uint32_t *lights = malloc(count * sizeof(*lights));
    float *found = malloc(count * sizeof(*found));
    struct buffer lights_out = device_buffer(s.gpu, NULL, count * sizeof(*lights));
    struct buffer pmfs_out = device_buffer(s.gpu, NULL, count * sizeof(*found));
    const struct kernel_arg args[] = {
        ARG_BUFFER(&s.nodes),    ARG_BUFFER(&s.points), ARG_BUFFER(&s.normals), ARG_VALUE(draws),
        ARG_BUFFER(&lights_out), ARG_BUFFER(&pmfs_out), ARG_VALUE(count),
    };
    DEVICE_RUN(s.gpu, &s.program, "light_bvh_draws", args, count);
    assert_ok(buffer_read(s.gpu, &lights_out, lights, count * sizeof(*lights)));
    assert_ok(buffer_read(s.gpu, &pmfs_out, found, count * sizeof(*found)));

    for (uint32_t i = 0; i < points; i++) {
        uint32_t times[LIGHTS] = {0};
        for (uint32_t k = 0; k < draws; k++) {
            const uint32_t light = lights[i * draws + k];
            if (light == EMITTER_NONE)
                continue;
            assert_in_range(light, 0, LIGHTS - 1);
            times[light]++;
            const double pmf = pmfs[i * LIGHTS + light];
            assert_close(found[i * draws + k], pmf, EPSILON * pmf);
        }
        for (uint32_t light = 0; light < LIGHTS; light++) {
            const double pmf = pmfs[i * LIGHTS + light];
            const double sigma = sqrt(pmf * (1.0 - pmf) / draws) + 1.0 / draws;
            assert_close((double)times[light] / draws, pmf, SIGMAS * sigma);
        }
    }
    buffer_free(s.gpu, &pmfs_out);
    buffer_free(s.gpu, &lights_out);
    free(found);
    free(lights);
    free(pmfs);
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
    float *pmfs = find_pmfs(&s, light_count);
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
        if (most[i] > 0.0f && !(pmfs[i] > 0.0f))
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
    free(pmfs);
    close_setup(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pmfs_sum_to_one_at_most),
        cmocka_unit_test(draws_follow_their_pmf),
        cmocka_unit_test(every_light_that_contributes_can_be_drawn),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
