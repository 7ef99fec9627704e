/**
 * @file
 * Samples one light on the device, from as many points and by as many numbers as a grid has cells,
 * path by path and by eights.
 */
#ifndef TESTS_DEVICE_LIGHT_SAMPLES_H
#define TESTS_DEVICE_LIGHT_SAMPLES_H

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "prep/prep_support.h"
#include "prep/vec3.h"
#include "shared/geometry.h"
#include "shared/light.h"
#include "shared/material.h"
#include "support.h"

#define GRID         128u // places on a light: so many along each edge
#define CELLS        (GRID * GRID)
#define SAME_EPSILON 2e-3 // relative: the same of one sample, fused otherwise
#define PI           3.14159265358979323846

/** The group's state. */
struct fixture {
    struct gpu *gpu;
    struct program program;
    struct buffer lights, shapes, vertices, triangles, materials; // one of each
    struct buffer texels;                                         // four
    struct buffer points, numbers, dirs, values;                  // [CELLS]
    float4 *cell_points, *cell_numbers, *cell_dirs, *cell_values; // the host's copies
    float4 *eight_dirs, *eight_values;                            // what eights made of the same
};

static struct fixture fixture;

/** A light, and the shape it points to: the first. */
struct shaped_light {
    struct light light;
    struct light_shape shape;
};

static inline int light_setup(void **state)
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
    f->cell_points = calloc(6 * CELLS, sizeof(float4));
    f->cell_numbers = f->cell_points + CELLS;
    f->cell_dirs = f->cell_points + 2 * CELLS;
    f->cell_values = f->cell_points + 3 * CELLS;
    f->eight_dirs = f->cell_points + 4 * CELLS;
    f->eight_values = f->cell_points + 5 * CELLS;
    for (uint32_t i = 0; i < CELLS; i++)
        f->cell_numbers[i] = (float4){((float)(i % GRID) + 0.5f) / GRID,
                                      ((float)(i / GRID) + 0.5f) / GRID, 0.0f, 0.0f};
    assert_ok(buffer_write(gpu, &f->numbers, f->cell_numbers, CELLS * sizeof(float4)));
    return 0;
}

static inline int light_teardown(void **state)
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

static inline void assert_same_row(const float4 *row, const float4 *expected)
{
    const float *a = &row->x;
    const float *b = &expected->x;
    for (int k = 0; k < 4; k++)
        assert_close(a[k], b[k], 1e-6 + SAME_EPSILON * fabs(b[k]));
}

/** Writes a light to the device. */
static inline void write_light(const struct shaped_light *light)
{
    struct fixture *f = &fixture;
    assert_ok(buffer_write(f->gpu, &f->lights, &light->light, sizeof(light->light)));
    assert_ok(buffer_write(f->gpu, &f->shapes, &light->shape, sizeof(light->shape)));
    assert_ok(buffer_write(f->gpu, &f->points, f->cell_points, CELLS * sizeof(float4)));
}

// Runs one of the kernels that sample.
static inline void run_samples(const char *name, float4 normal, float4 *dirs, float4 *values)
{
    struct fixture *f = &fixture;
    const uint32_t index = 0;
    const uint32_t count = CELLS;
    const struct kernel_arg args[] = {
        ARG_BUFFER(&f->lights),   ARG_BUFFER(&f->shapes),    ARG_VALUE(index),
        ARG_BUFFER(&f->vertices), ARG_BUFFER(&f->triangles), ARG_BUFFER(&f->materials),
        ARG_BUFFER(&f->texels),   ARG_BUFFER(&f->points),    ARG_VALUE(normal),
        ARG_BUFFER(&f->numbers),  ARG_VALUE(count),          ARG_BUFFER(&f->dirs),
        ARG_BUFFER(&f->values),
    };
    DEVICE_RUN(f->gpu, &f->program, name, args, count);
    assert_ok(buffer_read(f->gpu, &f->dirs, dirs, CELLS * sizeof(float4)));
    assert_ok(buffer_read(f->gpu, &f->values, values, CELLS * sizeof(float4)));
}

/** Samples a light from cell_points by cell_numbers, path by path and by eights; all 0 stands for
 * the normal where there is no surface. */
static inline void draw_samples(const struct shaped_light *light, float4 normal)
{
    struct fixture *f = &fixture;
    write_light(light);
    run_samples("light_samples", normal, f->cell_dirs, f->cell_values);
    run_samples("light_samples_together", normal, f->eight_dirs, f->eight_values);
}

/** The same where there is no surface, and by eights it is the same. */
static inline void sample(const struct shaped_light *light)
{
    struct fixture *f = &fixture;
    draw_samples(light, (float4){0.0f, 0.0f, 0.0f, 0.0f});
    for (uint32_t i = 0; i < CELLS; i++) {
        assert_same_row(&f->eight_dirs[i], &f->cell_dirs[i]);
        assert_same_row(&f->eight_values[i], &f->cell_values[i]);
    }
}

/** Puts all cells at one point. */
static inline void set_point(const double *point)
{
    for (uint32_t i = 0; i < CELLS; i++)
        fixture.cell_points[i] = (float4){(float)point[0], (float)point[1], (float)point[2], 0.0f};
}

static inline void sample_from(const struct shaped_light *light, const double *point)
{
    set_point(point);
    sample(light);
}

/** Solid angle of a triangle, with its sign (A. Van Oosterom, J. Strackee, 1983). */
static inline double triangle_angle(const double *a, const double *b, const double *c)
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

/** Solid angle of a light from a point. */
static inline double light_angle(const struct shaped_light *light, bool rectangle,
                                 const double *point)
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

/** A light of radiance 2, 3, 4 about the origin, 1 m in size; its front is where its normal points.
 */
static inline struct shaped_light make_area_light(bool rectangle, bool two_sided, double *normal,
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

/** A point on one side of a light, 0.7 m and more away from its plane. */
static inline void random_point(double *out, const double *normal, double side, uint64_t *seed)
{
    const double height = random_between(seed, 0.7, 3.0);
    for (int k = 0; k < 3; k++)
        out[k] = random_between(seed, -2.0, 2.0);
    const double off = vec3_dot(out, normal);
    for (int k = 0; k < 3; k++)
        out[k] += (side * height - off) * normal[k];
}

#endif
