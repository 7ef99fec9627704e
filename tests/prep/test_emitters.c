// Emitters against closed forms of their power, and what becomes a light at all.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>

#include "prep/emitters.h"
#include "prep_support.h"

#define PI      3.14159265358979323846
#define EPSILON 1e-5 // relative: a few roundings to float

// A quad of two triangles (0 1 2) (0 2 3), with its own material.
struct quad {
    struct geometry geometry;
    struct scene_material material;
    struct scene scene;
};

static const struct scene_texture_use no_texture = {.texture = SCENE_NONE};

static struct scene_material make_material(float r, float g, float b)
{
    return (struct scene_material){.name = "",
                                   .emission = {r, g, b},
                                   .base_texture = no_texture,
                                   .surface_texture = no_texture,
                                   .emissive_texture = no_texture,
                                   .specular_texture = no_texture,
                                   .specular_color_texture = no_texture};
}

// A parallelogram with a corner and two sides, its front along u x v.
static void make_quad(struct quad *out, const float *org, const float *u, const float *v)
{
    float corners[18];
    for (int k = 0; k < 3; k++) {
        corners[k] = corners[9 + k] = org[k];
        corners[3 + k] = org[k] + u[k];
        corners[6 + k] = corners[12 + k] = org[k] + u[k] + v[k];
        corners[15 + k] = org[k] + v[k];
    }
    out->geometry = make_geometry(corners, 2);
    out->material = make_material(1.0f, 2.0f, 3.0f);
    out->scene = (struct scene){.materials = &out->material, .material_count = 1};
}

static uint bits_of(float value)
{
    uint bits;
    memcpy(&bits, &value, sizeof(bits));
    return bits;
}

// A light's type and sides.
static uint kind_of(const struct light *light)
{
    return bits_of(light->color_kind.w) & (LIGHT_TYPE_MASK | LIGHT_TWO_SIDED);
}

static const struct light_shape *shape_of(const struct emitters *emitters, uint32_t light)
{
    const uint kind = bits_of(emitters->lights[light].color_kind.w);
    assert_true(kind >> LIGHT_SHAPE_SHIFT < emitters->shape_count);
    return &emitters->shapes[kind >> LIGHT_SHAPE_SHIFT];
}

static double luminance(double r, double g, double b)
{
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
}

static void assert_near(double found, double expected)
{
    assert_true(fabs(found - expected) <= EPSILON * fabs(expected));
}

static const float unit_org[3] = {1.0f, 2.0f, 3.0f};
static const float unit_u[3] = {2.0f, 0.0f, 0.0f};
static const float unit_v[3] = {0.0f, 3.0f, 0.0f};

// The point at (s, t) of a light, and its front's direction.
static void point_on(double *out, const struct light *light, const struct light_shape *shape,
                     double s, double t)
{
    out[0] = light->org_range.x + s * shape->edge_u.x + t * shape->edge_v.x;
    out[1] = light->org_range.y + s * shape->edge_u.y + t * shape->edge_v.y;
    out[2] = light->org_range.z + s * shape->edge_u.z + t * shape->edge_v.z;
}

static void check_rectangle(const struct emitters *emitters)
{
    assert_int_equal(emitters->light_count, 1);
    assert_int_equal(emitters->rectangle_count, 1);
    assert_int_equal(emitters->emissive_triangles, 2);
    assert_int_equal(emitters->triangle_emitters[0], 0);
    assert_int_equal(emitters->triangle_emitters[1], 0);
    const struct light *light = &emitters->lights[0];
    const struct light_shape *shape = shape_of(emitters, 0);
    assert_int_equal(kind_of(light), LIGHT_RECTANGLE);
    assert_near(shape->edge_u.w, 6.0);
    assert_near(emitters->power[0], PI * 6.0 * luminance(1, 2, 3));

    // It is the square of the unit plane that the quad is: front to +Z, x from 1 to 3, y from 2
    // to 5, each corner once.
    assert_true(shape->edge_u.x * shape->edge_v.y - shape->edge_u.y * shape->edge_v.x > 0.0f);
    double sum[2] = {0.0, 0.0};
    for (int i = 0; i < 4; i++) {
        double p[3];
        point_on(p, light, shape, i % 2, i / 2);
        assert_true(fabs(p[0] - 1.0) < EPSILON || fabs(p[0] - 3.0) < EPSILON);
        assert_true(fabs(p[1] - 2.0) < EPSILON || fabs(p[1] - 5.0) < EPSILON);
        assert_near(p[2], 3.0);
        sum[0] += p[0];
        sum[1] += p[1];
    }
    assert_near(sum[0], 8.0);
    assert_near(sum[1], 14.0);
}

static void rectangles_are_found_however_they_are_indexed(void **state)
{
    (void)state;
    struct quad quad;
    make_quad(&quad, unit_org, unit_u, unit_v);
    for (int turn = 0; turn < 9; turn++) {
        for (int i = 0; i < 2; i++) {
            struct triangle *t = &quad.geometry.triangles[i];
            if (i == 0 || turn % 3 == 0)
                *t = (struct triangle){t->v1, t->v2, t->v0, 0};
        }
        struct emitters emitters;
        assert_int_equal(emitters_build(&emitters, &quad.scene, &quad.geometry), STATUS_OK);
        check_rectangle(&emitters);
        emitters_free(&emitters);
    }
    geometry_free(&quad.geometry);
}

// Counts the triangle lights of a quad, of which there must be two and no rectangle.
static void check_two_triangles(const struct quad *quad, double power)
{
    struct emitters emitters;
    assert_int_equal(emitters_build(&emitters, &quad->scene, &quad->geometry), STATUS_OK);
    assert_int_equal(emitters.light_count, 2);
    assert_int_equal(emitters.triangle_count, 2);
    assert_int_equal(emitters.emissive_triangles, 2);
    double sum = 0.0;
    for (uint32_t i = 0; i < 2; i++) {
        assert_int_equal(bits_of(shape_of(&emitters, i)->edge_v.w), i);
        assert_int_equal(emitters.triangle_emitters[i], i);
        assert_int_equal(kind_of(&emitters.lights[i]) & LIGHT_TYPE_MASK, LIGHT_TRIANGLE);
        sum += emitters.power[i];
    }
    assert_near(sum, power);
    emitters_free(&emitters);
}

static void other_quads_stay_two_triangles(void **state)
{
    (void)state;
    static const float skew[3] = {0.01f, 3.0f, 0.0f};
    const double power = PI * 6.0 * luminance(1, 2, 3);
    struct quad quad;

    make_quad(&quad, unit_org, unit_u, skew); // a parallelogram
    check_two_triangles(&quad, power);
    geometry_free(&quad.geometry);

    make_quad(&quad, unit_org, unit_u, unit_v);
    quad.material.masked = true;
    check_two_triangles(&quad, power);
    quad.material.masked = false;
    quad.geometry.vertices[5].pos_normal.z += 0.01f; // folded
    quad.geometry.vertices[5].pos_normal.x -= 1e-9f;
    check_two_triangles(&quad, 0.5 * power * (1.0 + sqrt(9.0 + 1e-4) / 3.0));
    quad.geometry.vertices[5].pos_normal.z -= 0.01f;
    quad.geometry.triangles[1] = (struct triangle){3, 5, 4, 0}; // fronts to either side
    check_two_triangles(&quad, power);
    geometry_free(&quad.geometry);
}

static void materials_that_differ_do_not_merge(void **state)
{
    (void)state;
    struct quad quad;
    make_quad(&quad, unit_org, unit_u, unit_v);
    const struct scene_material materials[2] = {quad.material, quad.material};
    quad.scene.materials = (struct scene_material *)materials;
    quad.scene.material_count = 2;
    quad.geometry.triangles[1].material = 1;
    check_two_triangles(&quad, PI * 6.0 * luminance(1, 2, 3));
    geometry_free(&quad.geometry);
}

static void two_sided_lights_have_twice_the_power(void **state)
{
    (void)state;
    struct quad quad;
    struct emitters emitters;
    make_quad(&quad, unit_org, unit_u, unit_v);
    quad.material.double_sided = true;
    assert_int_equal(emitters_build(&emitters, &quad.scene, &quad.geometry), STATUS_OK);
    assert_int_equal(kind_of(&emitters.lights[0]), LIGHT_RECTANGLE | LIGHT_TWO_SIDED);
    assert_near(emitters.power[0], 2.0 * PI * 6.0 * luminance(1, 2, 3));
    emitters_free(&emitters);
    geometry_free(&quad.geometry);
}

static void textured_power_is_that_of_the_mean(void **state)
{
    (void)state;
    // Red on half of the texels, sRGB 188 on the others: 0.5028865 linear.
    uint8_t rgba[16] = {255, 0, 0, 255, 188, 188, 188, 255, 188, 188, 188, 9, 255, 0, 0, 0};
    struct scene_image image = {.name = "", .width = 2, .height = 2, .rgba = rgba};
    struct scene_texture texture = {.image = 0};
    struct quad quad;
    make_quad(&quad, unit_org, unit_u, unit_v);
    quad.material.emissive_texture.texture = 0;
    quad.scene.images = &image;
    quad.scene.image_count = 1;
    quad.scene.textures = &texture;
    quad.scene.texture_count = 1;
    const double gray = 0.5028865;
    check_two_triangles(&quad, PI * 6.0 * luminance(0.5 + gray / 2, gray, 1.5 * gray));

    // Its colour is the factor alone.
    struct emitters emitters;
    assert_int_equal(emitters_build(&emitters, &quad.scene, &quad.geometry), STATUS_OK);
    assert_true(emitters.lights[0].color_kind.x == 1.0f && emitters.lights[0].color_kind.z == 3.0f);
    emitters_free(&emitters);

    memset(rgba, 0, sizeof(rgba)); // black
    assert_int_equal(emitters_build(&emitters, &quad.scene, &quad.geometry), STATUS_OK);
    assert_int_equal(emitters.light_count, 0);
    assert_null(emitters.triangle_emitters);
    emitters_free(&emitters);
    geometry_free(&quad.geometry);
}

static void surfaces_without_power_are_left_out(void **state)
{
    (void)state;
    struct quad quad;
    struct emitters emitters;
    make_quad(&quad, unit_org, unit_u, unit_v);
    quad.material.unlit = true;
    assert_int_equal(emitters_build(&emitters, &quad.scene, &quad.geometry), STATUS_OK);
    assert_int_equal(emitters.light_count, 0);
    assert_null(emitters.triangle_emitters);
    emitters_free(&emitters);

    quad.material.unlit = false;
    quad.geometry.triangles[0].v2 = quad.geometry.triangles[0].v1; // no area
    assert_int_equal(emitters_build(&emitters, &quad.scene, &quad.geometry), STATUS_OK);
    assert_int_equal(emitters.light_count, 1);
    assert_int_equal(emitters.emissive_triangles, 1);
    assert_int_equal(emitters.triangle_emitters[0], EMITTER_NONE);
    assert_int_equal(emitters.triangle_emitters[1], 0);
    emitters_free(&emitters);
    geometry_free(&quad.geometry);
}

static void punctual_lights_follow_the_file(void **state)
{
    (void)state;
    struct scene_light lights[] = {
        {.name = "p", .type = SCENE_LIGHT_POINT, .color = {5, 6, 7}, .position = {1, 2, 3}},
        {.name = "black", .type = SCENE_LIGHT_POINT},
        {.name = "sun",
         .type = SCENE_LIGHT_DIRECTIONAL,
         .color = {1, 2, 3},
         .direction = {0, -1, 0}},
        {.name = "s",
         .type = SCENE_LIGHT_SPOT,
         .color = {1, 1, 1},
         .direction = {0, 0, -1},
         .range = 9.0f,
         .inner_angle_rad = 0.3f,
         .outer_angle_rad = 0.6f},
        {.name = "night", .type = SCENE_LIGHT_DIRECTIONAL},
    };
    const struct scene scene = {.lights = lights, .light_count = 5};
    const struct geometry geometry = {0};
    struct emitters emitters;
    assert_int_equal(emitters_build(&emitters, &scene, &geometry), STATUS_OK);
    assert_int_equal(emitters.light_count, 2);
    assert_int_equal(emitters.point_count, 1);
    assert_int_equal(emitters.spot_count, 1);
    assert_int_equal(emitters.directional_count, 1);
    assert_true(emitters.directional[0].dir.y == -1.0f && emitters.directional[0].color.z == 3.0f);

    const struct light *point = &emitters.lights[0];
    assert_int_equal(kind_of(point), LIGHT_POINT);
    assert_true(point->org_range.w == LIGHT_NO_RANGE && point->org_range.z == 3.0f);
    assert_near(emitters.power[0], 4.0 * PI * luminance(5, 6, 7));

    // The falloff is 1 on the inner cone and 0 on the outer one.
    const struct light *spot = &emitters.lights[1];
    const struct light_shape *cone = shape_of(&emitters, 1);
    assert_int_equal(kind_of(spot), LIGHT_SPOT);
    assert_true(spot->org_range.w == 9.0f && cone->edge_u.z == -1.0f);
    assert_near(cos(0.3f) * cone->edge_u.w + cone->edge_v.w, 1.0);
    assert_true(fabs(cos(0.6f) * cone->edge_u.w + cone->edge_v.w) < EPSILON);
    assert_true(emitters.power[1] > 0.0f && emitters.power[1] < 4.0 * PI);
    emitters_free(&emitters);
}

static void hard_cones_stay_finite(void **state)
{
    (void)state;
    struct scene_light light = {.name = "s",
                                .type = SCENE_LIGHT_SPOT,
                                .color = {1, 1, 1},
                                .direction = {0, 0, -1},
                                .inner_angle_rad = 0.5f,
                                .outer_angle_rad = 0.5f};
    const struct scene scene = {.lights = &light, .light_count = 1};
    const struct geometry geometry = {0};
    struct emitters emitters;
    assert_int_equal(emitters_build(&emitters, &scene, &geometry), STATUS_OK);
    assert_near(shape_of(&emitters, 0)->edge_u.w, 1000.0);
    emitters_free(&emitters);
    emitters_free(&emitters);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(rectangles_are_found_however_they_are_indexed),
        cmocka_unit_test(other_quads_stay_two_triangles),
        cmocka_unit_test(materials_that_differ_do_not_merge),
        cmocka_unit_test(two_sided_lights_have_twice_the_power),
        cmocka_unit_test(textured_power_is_that_of_the_mean),
        cmocka_unit_test(surfaces_without_power_are_left_out),
        cmocka_unit_test(punctual_lights_follow_the_file),
        cmocka_unit_test(hard_cones_stay_finite),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
