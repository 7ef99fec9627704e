// Sampling points and spots, which follow KHR_lights_punctual.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "light_samples.h"
#include "prep/emitters.h"

#define VALUE_EPSILON 1e-5 // relative: a few roundings; the window's difference loses some digits
#define CONE_EPSILON  2e-4 // of the squared cone: narrow ones divide a cosine's rounding by 0.001

// The one light of a scene of its own.
static struct shaped_light make_punctual(const struct scene_light *source)
{
    static struct scene_material material;
    struct scene_light light = *source;
    const struct scene scene = {
        .lights = &light, .light_count = 1, .materials = &material, .material_count = 1};
    const struct geometry geometry = {0};
    struct emitters emitters;
    assert_ok(emitters_build(&emitters, &scene, &geometry));
    assert_int_equal(emitters.light_count, 1);
    struct shaped_light out = {.light = emitters.lights[0]};
    if (emitters.shape_count > 0)
        out.shape = emitters.shapes[0];
    emitters_free(&emitters);
    return out;
}

// Intensity over distance squared, as KHR_lights_punctual has it.
static double punctual_oracle(const struct scene_light *l, const double *point)
{
    double way[3], along[3], axis[3];
    vec3_load(along, l->position);
    vec3_load(axis, l->direction);
    vec3_sub(way, point, along);
    const double d = vec3_length(way);
    double value = l->color[0] / (d * d);
    if (l->range > 0.0f)
        value *= fmax(fmin(1.0 - pow(d / l->range, 4.0), 1.0), 0.0);
    if (l->type == SCENE_LIGHT_SPOT) {
        const double outer = cos(l->outer_angle_rad);
        const double scale = 1.0 / fmax(0.001, cos(l->inner_angle_rad) - outer);
        const double cone = vec3_dot(axis, way) / d * scale - outer * scale;
        value *= pow(fmax(fmin(cone, 1.0), 0.0), 2.0);
    }
    return value;
}

// Compares at random points around the light; `epsilon` is relative to the light without its cone.
static void check_punctual(const struct scene_light *source, double epsilon)
{
    const struct shaped_light light = make_punctual(source);
    struct scene_light whole = *source;
    whole.type = SCENE_LIGHT_POINT;
    whole.range = 0.0f;
    uint64_t seed = 3;
    for (uint32_t i = 0; i < CELLS; i++)
        fixture.cell_points[i] = (float4){(float)random_between(&seed, -6.0, 6.0),
                                          (float)random_between(&seed, -6.0, 6.0),
                                          (float)random_between(&seed, -6.0, 6.0), 0.0f};
    sample(&light);
    uint32_t lit = 0;
    for (uint32_t i = 0; i < CELLS; i++) {
        double point[3];
        vec3_load(point, &fixture.cell_points[i].x);
        const double expected = punctual_oracle(source, point);
        const float4 value = fixture.cell_values[i];
        assert_close(value.x, expected, epsilon * punctual_oracle(&whole, point));
        assert_true(value.w == 0.0f); // no ray can hit it
        lit += expected > 0.0;
    }
    assert_true(lit > 0);
}

static void points_fall_off_with_the_square(void **state)
{
    device_of(state);
    const struct scene_light light = {
        .type = SCENE_LIGHT_POINT, .color = {5.0f, 0.1f, 0.2f}, .position = {1.0f, 2.0f, -1.0f}};
    check_punctual(&light, VALUE_EPSILON);
}

static void ranges_end_by_the_window(void **state)
{
    device_of(state);
    for (float range = 0.5f; range < 20.0f; range *= 2.0f) {
        const struct scene_light light = {.type = SCENE_LIGHT_POINT,
                                          .color = {5.0f, 0.1f, 0.2f},
                                          .position = {1.0f, 2.0f, -1.0f},
                                          .range = range};
        check_punctual(&light, VALUE_EPSILON);
    }
}

static void spots_follow_the_cone(void **state)
{
    device_of(state);
    static const float angles[][2] = {
        {0.0f, 0.7854f}, {0.3f, 0.5f}, {0.5f, 0.5001f}, {0.0f, 1.5707f}, {1.2f, 1.5f}};
    for (size_t i = 0; i < sizeof(angles) / sizeof(angles[0]); i++) {
        const struct scene_light light = {.type = SCENE_LIGHT_SPOT,
                                          .color = {5.0f, 0.1f, 0.2f},
                                          .position = {1.0f, 2.0f, -1.0f},
                                          .direction = {0.36f, -0.48f, 0.8f},
                                          .range = i & 1 ? 5.0f : 0.0f,
                                          .inner_angle_rad = angles[i][0],
                                          .outer_angle_rad = angles[i][1]};
        check_punctual(&light, CONE_EPSILON);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(points_fall_off_with_the_square),
        cmocka_unit_test(ranges_end_by_the_window),
        cmocka_unit_test(spots_follow_the_cone),
    };
    return cmocka_run_group_tests(tests, light_setup, light_teardown);
}
