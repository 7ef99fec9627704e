// Sampling a light: densities are those of solid angle, and punctual lights follow
// KHR_lights_punctual.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "prep/emitters.h"
#include "prep/prep_support.h"
#include "prep/vec3.h"
#include "shared/geometry.h"
#include "shared/material.h"
#include "support.h"

#define GRID          128u // places on a light: so many along each edge
#define CELLS         (GRID * GRID)
#define POINTS        40
#define ANGLE_EPSILON 2e-3 // relative: the grid's error from half a size away
#define VALUE_EPSILON 1e-5 // relative: a few roundings; the window's difference loses some digits
#define CONE_EPSILON  2e-4 // of the squared cone: narrow ones divide a cosine's rounding by 0.001
#define SAME_EPSILON  2e-3 // relative: the same of one sample, fused otherwise
#define PI            3.14159265358979323846

struct fixture {
    struct gpu *gpu;
    struct program program;
    struct buffer lights, shapes, vertices, triangles, materials; // one of each
    struct buffer texels;                                         // four
    struct buffer points, numbers, dirs, values;                  // [CELLS]
    float4 *cell_points, *cell_numbers, *cell_dirs, *cell_values; // the host's copies
};

static struct fixture fixture;

// A light, and the shape it points to: the first.
struct shaped_light {
    struct light light;
    struct light_shape shape;
};

static int light_setup(void **state)
{
    struct fixture *f = &fixture;
    if (device_setup(state) != 0 || *state == NULL)
        return *state == NULL ? 0 : -1;
    struct gpu *gpu = f->gpu = *state;
    f->program = device_program(gpu, "light", NULL);
    f->lights = device_buffer(gpu, NULL, sizeof(struct light));
    f->shapes = device_buffer(gpu, NULL, sizeof(struct light_shape));
    f->vertices = device_buffer(gpu, NULL, 3 * sizeof(struct vertex));
    f->triangles = device_buffer(gpu, NULL, sizeof(struct triangle));
    f->materials = device_buffer(gpu, NULL, sizeof(struct material));
    f->texels = device_buffer(gpu, NULL, 4 * sizeof(uint32_t));
    f->points = device_buffer(gpu, NULL, CELLS * sizeof(float4));
    f->numbers = device_buffer(gpu, NULL, CELLS * sizeof(float4));
    f->dirs = device_buffer(gpu, NULL, CELLS * sizeof(float4));
    f->values = device_buffer(gpu, NULL, CELLS * sizeof(float4));
    f->cell_points = calloc(4 * CELLS, sizeof(float4));
    f->cell_numbers = f->cell_points + CELLS;
    f->cell_dirs = f->cell_points + 2 * CELLS;
    f->cell_values = f->cell_points + 3 * CELLS;
    for (uint32_t i = 0; i < CELLS; i++)
        f->cell_numbers[i] = (float4){((float)(i % GRID) + 0.5f) / GRID,
                                      ((float)(i / GRID) + 0.5f) / GRID, 0.0f, 0.0f};
    assert_ok(buffer_write(gpu, &f->numbers, f->cell_numbers, CELLS * sizeof(float4)));
    return 0;
}

static int light_teardown(void **state)
{
    struct fixture *f = &fixture;
    if (*state != NULL) {
        struct buffer *buffers[] = {&f->lights,    &f->shapes, &f->vertices, &f->triangles,
                                    &f->materials, &f->texels, &f->points,   &f->numbers,
                                    &f->dirs,      &f->values};
        for (size_t i = 0; i < sizeof(buffers) / sizeof(buffers[0]); i++)
            buffer_free(f->gpu, buffers[i]);
        free(f->cell_points);
        program_free(&f->program);
    }
    return device_teardown(state);
}

static void assert_same_row(const float4 *row, const float4 *expected)
{
    const float *a = &row->x;
    const float *b = &expected->x;
    for (int k = 0; k < 4; k++)
        assert_close(a[k], b[k], 1e-6 + SAME_EPSILON * fabs(b[k]));
}

// Samples a light from cell_points by cell_numbers into cell_dirs and cell_values.
static void sample(const struct shaped_light *light)
{
    struct fixture *f = &fixture;
    const uint32_t index = 0;
    const uint32_t count = CELLS;
    const struct kernel_arg args[] = {
        ARG_BUFFER(&f->lights),   ARG_BUFFER(&f->shapes),    ARG_VALUE(index),
        ARG_BUFFER(&f->vertices), ARG_BUFFER(&f->triangles), ARG_BUFFER(&f->materials),
        ARG_BUFFER(&f->texels),   ARG_BUFFER(&f->points),    ARG_BUFFER(&f->numbers),
        ARG_VALUE(count),         ARG_BUFFER(&f->dirs),      ARG_BUFFER(&f->values),
    };
    assert_ok(buffer_write(f->gpu, &f->lights, &light->light, sizeof(light->light)));
    assert_ok(buffer_write(f->gpu, &f->shapes, &light->shape, sizeof(light->shape)));
    assert_ok(buffer_write(f->gpu, &f->points, f->cell_points, CELLS * sizeof(float4)));
    DEVICE_RUN(f->gpu, &f->program, "light_samples", args, count);
    assert_ok(buffer_read(f->gpu, &f->dirs, f->cell_dirs, CELLS * sizeof(float4)));
    assert_ok(buffer_read(f->gpu, &f->values, f->cell_values, CELLS * sizeof(float4)));

    // By eights it is the same.
    float4 *dirs = calloc(2 * CELLS, sizeof(float4));
    float4 *values = dirs + CELLS;
    DEVICE_RUN(f->gpu, &f->program, "light_samples_by_eights", args, count);
    assert_ok(buffer_read(f->gpu, &f->dirs, dirs, CELLS * sizeof(float4)));
    assert_ok(buffer_read(f->gpu, &f->values, values, CELLS * sizeof(float4)));
    for (uint32_t i = 0; i < CELLS; i++) {
        assert_same_row(&dirs[i], &f->cell_dirs[i]);
        assert_same_row(&values[i], &f->cell_values[i]);
    }
    free(dirs);
}

static void sample_from(const struct shaped_light *light, const double *point)
{
    for (uint32_t i = 0; i < CELLS; i++)
        fixture.cell_points[i] = (float4){(float)point[0], (float)point[1], (float)point[2], 0.0f};
    sample(light);
}

// ---- lights with an area

// Solid angle of a triangle, with its sign (A. Van Oosterom, J. Strackee, 1983).
static double triangle_angle(const double *a, const double *b, const double *c)
{
    double bc[3];
    vec3_cross(bc, b, c);
    const double la = vec3_length(a);
    const double lb = vec3_length(b);
    const double lc = vec3_length(c);
    const double below =
        la * lb * lc + vec3_dot(a, b) * lc + vec3_dot(a, c) * lb + vec3_dot(b, c) * la;
    return 2.0 * atan2(vec3_dot(a, bc), below);
}

// Solid angle of a light from a point.
static double light_angle(const struct shaped_light *light, bool rectangle, const double *point)
{
    double corners[4][3];
    for (int k = 0; k < 3; k++) {
        const double org = (&light->light.org_range.x)[k] - point[k];
        const double u = (&light->shape.edge_u.x)[k];
        const double v = (&light->shape.edge_v.x)[k];
        corners[0][k] = org;
        corners[1][k] = org + u;
        corners[2][k] = org + u + v;
        corners[3][k] = org + v;
    }
    if (!rectangle)
        return fabs(triangle_angle(corners[0], corners[1], corners[3]));
    return fabs(triangle_angle(corners[0], corners[1], corners[2])) +
           fabs(triangle_angle(corners[0], corners[2], corners[3]));
}

// A light of radiance 2, 3, 4 about the origin, 1 m in size; its front is where its normal points.
static struct shaped_light make_area_light(bool rectangle, bool two_sided, double *normal,
                                           uint64_t *seed)
{
    struct shaped_light light = {.light = {.color_kind = {2.0f, 3.0f, 4.0f, 0.0f}}};
    const uint32_t kind =
        (rectangle ? LIGHT_RECTANGLE : LIGHT_TRIANGLE) | (two_sided ? LIGHT_TWO_SIDED : 0u);
    double u[3], v[3], area;
    do {
        for (int k = 0; k < 3; k++) {
            u[k] = random_between(seed, -1.0, 1.0);
            v[k] = random_between(seed, -1.0, 1.0);
        }
        const double along = vec3_dot(u, v) / vec3_dot(u, u);
        for (int k = 0; k < 3; k++)
            v[k] -= rectangle ? along * u[k] : 0.0;
        vec3_cross(normal, u, v);
        area = vec3_length(normal);
    } while (area < 0.3);
    for (int k = 0; k < 3; k++) {
        (&light.light.org_range.x)[k] = (float)(-0.5 * (u[k] + v[k]));
        (&light.shape.edge_u.x)[k] = (float)u[k];
        (&light.shape.edge_v.x)[k] = (float)v[k];
        normal[k] /= area;
    }
    light.light.color_kind.w = bits_float(kind);
    light.shape.edge_u.w = (float)(rectangle ? area : 0.5 * area);
    light.shape.edge_v.w = bits_float(0); // the triangle
    return light;
}

// A point on one side of a light, 0.7 m and more away from its plane.
static void random_point(double *out, const double *normal, double side, uint64_t *seed)
{
    const double height = random_between(seed, 0.7, 3.0);
    for (int k = 0; k < 3; k++)
        out[k] = random_between(seed, -2.0, 2.0);
    const double off = vec3_dot(out, normal);
    for (int k = 0; k < 3; k++)
        out[k] += (side * height - off) * normal[k];
}

// The mean of 1 / density over all places is the solid angle.
static void check_angle(bool rectangle, bool two_sided)
{
    uint64_t seed = 1;
    for (int i = 0; i < POINTS; i++) {
        double normal[3], point[3];
        const double side = i & 1 ? -1.0 : 1.0;
        const struct shaped_light light = make_area_light(rectangle, two_sided, normal, &seed);
        random_point(point, normal, side, &seed);
        sample_from(&light, point);
        double sum = 0.0;
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            const float4 value = fixture.cell_values[cell];
            if (side < 0.0 && !two_sided) {
                assert_true(value.x == 0.0f && value.y == 0.0f && value.z == 0.0f);
                continue;
            }
            assert_true(value.x == 2.0f && value.y == 3.0f && value.z == 4.0f);
            sum += 1.0 / value.w / CELLS;
        }
        const double angle = side < 0.0 && !two_sided ? 0.0 : light_angle(&light, rectangle, point);
        assert_close(sum, angle, ANGLE_EPSILON * angle);
    }
}

static void densities_integrate_to_the_solid_angle(void **state)
{
    device_of(state);
    check_angle(false, false);
    check_angle(false, true);
    check_angle(true, false);
    check_angle(true, true);
}

// Each sample lies on the light, at the distance that it says.
static void samples_lie_on_the_light(void **state)
{
    device_of(state);
    uint64_t seed = 2;
    for (int i = 0; i < 8; i++) {
        const bool rectangle = i & 1;
        double normal[3], point[3], to[3], e[3], u[3], v[3], cross[3];
        const struct shaped_light light = make_area_light(rectangle, false, normal, &seed);
        random_point(point, normal, 1.0, &seed);
        sample_from(&light, point);
        vec3_load(u, &light.shape.edge_u.x);
        vec3_load(v, &light.shape.edge_v.x);
        vec3_cross(cross, u, v);
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            const float4 dir = fixture.cell_dirs[cell];
            for (int k = 0; k < 3; k++)
                to[k] = point[k] + (double)dir.w * (&dir.x)[k] - (&light.light.org_range.x)[k];
            assert_close(vec3_dot(to, normal), 0.0, VALUE_EPSILON * dir.w);
            vec3_cross(e, to, v);
            const double s = vec3_dot(e, cross) / vec3_dot(cross, cross);
            vec3_cross(e, u, to);
            const double t = vec3_dot(e, cross) / vec3_dot(cross, cross);
            assert_true(s > 0.0 && t > 0.0);
            assert_true(rectangle ? s < 1.0 && t < 1.0 : s + t < 1.0 + 1e-4);
        }
    }
}

// A disc seen from its axis, where it takes 2 pi (1 - cos) of its angle; its places are even: half
// of them lie within 1 / sqrt(2) of the radius.
static void discs_are_sampled_evenly(void **state)
{
    device_of(state);
    const double radius = 0.8;
    const double height = 1.5;
    const double point[3] = {0.0, 0.0, height};
    const struct shaped_light light = {
        .light = {.color_kind = {2.0f, 3.0f, 4.0f, bits_float(LIGHT_DISC)}},
        .shape = {.edge_u = {(float)radius, 0.0f, 0.0f, (float)(PI * radius * radius)},
                  .edge_v = {0.0f, (float)radius, 0.0f, bits_float(EMITTER_NONE)}},
    };
    sample_from(&light, point);
    double sum = 0.0;
    uint32_t inner = 0;
    for (uint32_t cell = 0; cell < CELLS; cell++) {
        const float4 dir = fixture.cell_dirs[cell];
        const double x = (double)dir.w * dir.x;
        const double y = (double)dir.w * dir.y;
        assert_close(height + (double)dir.w * dir.z, 0.0, VALUE_EPSILON);
        assert_true(sqrt(x * x + y * y) <= radius * (1.0 + VALUE_EPSILON));
        inner += x * x + y * y < 0.5 * radius * radius;
        sum += 1.0 / fixture.cell_values[cell].w / CELLS;
    }
    const double angle = 2.0 * PI * (1.0 - height / sqrt(radius * radius + height * height));
    assert_close(sum, angle, ANGLE_EPSILON * angle);
    assert_close((double)inner / CELLS, 0.5, 0.01);
}

// Four texels, taken nearest: each quarter of the uv square has its own emission.
static void textured_triangles_emit_their_texels(void **state)
{
    device_of(state);
    static const uint32_t texels[4] = {0xff0000ff, 0xff00ff00, 0xffff0000, 0xff000000};
    struct vertex corners[3] = {0};
    struct material material = {.base = {1.0f, 1.0f, 1.0f, 1.0f}};
    struct texture_slot *slot = &material.textures[TEXTURE_EMISSIVE];
    *slot = (struct texture_slot){.uv_matrix = {1.0f, 0.0f, 0.0f, 1.0f},
                                  .size = 2 | 2 << 16,
                                  .flags = TEXTURE_PRESENT | TEXTURE_NEAREST};
    const struct triangle triangle = {0, 1, 2, 0};
    corners[1].uv.x = 1.0f;
    corners[2].uv.y = 1.0f;
    uint64_t seed = 4;
    double normal[3], point[3];
    const struct shaped_light light = make_area_light(false, false, normal, &seed);
    random_point(point, normal, 1.0, &seed);
    struct gpu *gpu = fixture.gpu;
    assert_ok(buffer_write(gpu, &fixture.texels, texels, sizeof(texels)));
    assert_ok(buffer_write(gpu, &fixture.vertices, corners, sizeof(corners)));
    assert_ok(buffer_write(gpu, &fixture.triangles, &triangle, sizeof(triangle)));
    assert_ok(buffer_write(gpu, &fixture.materials, &material, sizeof(material)));
    sample_from(&light, point);
    for (uint32_t i = 0; i < CELLS; i++) {
        const float4 n = fixture.cell_numbers[i];
        const bool folded = n.x + n.y > 1.0f;
        const double s = folded ? 1.0 - n.x : n.x;
        const double t = folded ? 1.0 - n.y : n.y;
        const uint32_t texel = texels[(s > 0.5) + 2 * (t > 0.5)];
        const double expected[3] = {texel & 1 ? 2.0 : 0.0, texel >> 8 & 1 ? 3.0 : 0.0,
                                    texel >> 16 & 1 ? 4.0 : 0.0};
        assert_close3(fixture.cell_values[i], expected, 0.0);
    }
    memset(&material, 0, sizeof(material));
    assert_ok(buffer_write(gpu, &fixture.materials, &material, sizeof(material)));
}

// ---- punctual lights

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
        cmocka_unit_test(densities_integrate_to_the_solid_angle),
        cmocka_unit_test(samples_lie_on_the_light),
        cmocka_unit_test(discs_are_sampled_evenly),
        cmocka_unit_test(textured_triangles_emit_their_texels),
        cmocka_unit_test(points_fall_off_with_the_square),
        cmocka_unit_test(ranges_end_by_the_window),
        cmocka_unit_test(spots_follow_the_cone),
    };
    return cmocka_run_group_tests(tests, light_setup, light_teardown);
}
