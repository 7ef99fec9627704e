// Sampling lights that are near: evenly in solid angle, so that no sample outshines the others.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "light_samples.h"

#define CASES           60
#define CORNERS         12     // of a polygon, at most
#define LEAST           1e-4   // sr: lights that take less are sampled by area
#define PLACE_EPSILON   2e-5   // m: of places on lights of 1 m
#define SHARE_EPSILON   0.01   // of one: cells of the grid that the edge of a part cuts
#define INTEGRAL        5e-3   // relative: the error of the grid, where all turns within few cells
#define DENSITY_EPSILON 2e-3   // relative: distance and cosine by another way
#define HEMISPHERE      6.2832 // sr

// An upright triangle or rectangle, and a point near it: over it or beside it, at any height.
struct near_case {
    struct shaped_light light;
    double normal[3]; // of the light
    double point[3];  // as floats hold it
    double height;    // of the point over the light's plane, m
    double angle;     // of the light, sr
    bool rectangle;
};

// The light's part with s >= s0 and t >= t0.
static struct shaped_light part_of(const struct near_case *c, double s0, double t0)
{
    struct shaped_light part = c->light;
    const double u_left = c->rectangle ? 1.0 - s0 : 1.0 - s0 - t0;
    const double v_left = c->rectangle ? 1.0 - t0 : 1.0 - s0 - t0;
    for (int k = 0; k < 3; k++) {
        float *u = &part.shape.edge_u.x + k;
        float *v = &part.shape.edge_v.x + k;
        (&part.light.org_range.x)[k] += (float)(s0 * *u + t0 * *v);
        *u *= (float)u_left;
        *v *= (float)v_left;
    }
    return part;
}

static struct near_case make_case(int i, uint64_t *seed)
{
    struct near_case c = {.rectangle = i & 1};
    c.light = make_area_light(c.rectangle, i & 2, c.normal, seed);
    c.height = pow(10.0, random_between(seed, -3.0, 0.0));
    const double side = (i & 2) && (i & 4) ? -1.0 : 1.0;
    const double s = random_between(seed, -0.2, 1.2);
    const double t = random_between(seed, -0.2, 1.2);
    for (int k = 0; k < 3; k++)
        c.point[k] = (float)((&c.light.light.org_range.x)[k] + s * (&c.light.shape.edge_u.x)[k] +
                             t * (&c.light.shape.edge_v.x)[k] + side * c.height * c.normal[k]);
    c.angle = light_angle(&c.light, c.rectangle, c.point);
    return c;
}

static bool is_near(const struct near_case *c)
{
    double u[3], v[3];
    vec3_load(u, &c->light.shape.edge_u.x);
    vec3_load(v, &c->light.shape.edge_v.x);
    return vec3_dot(c->point, c->point) < vec3_dot(u, u) + vec3_dot(v, v) && c->angle > LEAST;
}

// Where on the light a sample lies: s, t and the distance from its plane.
static void find_place(double *out, const struct near_case *c, const float4 *dir)
{
    double to[3], e[3], u[3], v[3], cross[3];
    vec3_load(u, &c->light.shape.edge_u.x);
    vec3_load(v, &c->light.shape.edge_v.x);
    vec3_cross(cross, u, v);
    for (int k = 0; k < 3; k++)
        to[k] = c->point[k] + (double)dir->w * (&dir->x)[k] - (&c->light.light.org_range.x)[k];
    vec3_cross(e, to, v);
    out[0] = vec3_dot(e, cross) / vec3_dot(cross, cross);
    vec3_cross(e, u, to);
    out[1] = vec3_dot(e, cross) / vec3_dot(cross, cross);
    out[2] = vec3_dot(to, c->normal);
}

// Samples a case from its point; eights find the same places.
static void sample_case(const struct near_case *c)
{
    const struct fixture *f = &fixture;
    const float4 nowhere = {0.0f, 0.0f, 0.0f, 0.0f};
    set_point(c->point);
    draw_samples(&c->light, nowhere);
    for (uint32_t i = 0; i < CELLS; i++) {
        const float *dir = &f->cell_dirs[i].x;
        const float *eight = &f->eight_dirs[i].x;
        for (int k = 0; k < 3; k++)
            assert_close(eight[k] * eight[3], dir[k] * dir[3], PLACE_EPSILON);
        assert_close(f->eight_values[i].w, f->cell_values[i].w,
                     SAME_EPSILON * fabs(f->cell_values[i].w));
    }
}

static void samples_are_even_in_solid_angle(void **state)
{
    device_of(state);
    uint64_t seed = 1;
    int near = 0;
    for (int i = 0; i < CASES; i++) {
        const struct near_case c = make_case(i, &seed);
        if (!is_near(&c))
            continue;
        near++;
        sample_case(&c);

        // All have the same density, and the part with s >= s0 and t >= t0 gets its share.
        const double s0 = i % 3 == 0 ? 0.0 : random_between(&seed, 0.0, 0.5);
        const double t0 = i % 3 == 1 ? 0.0 : random_between(&seed, 0.0, 0.5);
        const struct shaped_light part = part_of(&c, s0, t0);
        uint32_t inside = 0;
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            double place[3];
            find_place(place, &c, &fixture.cell_dirs[cell]);
            assert_close(place[2], 0.0, PLACE_EPSILON);
            assert_true(place[0] > -PLACE_EPSILON && place[1] > -PLACE_EPSILON);
            assert_true((c.rectangle ? fmax(place[0], place[1]) : place[0] + place[1]) <
                        1.0 + PLACE_EPSILON);
            // Float's rounding of the point is as much as another height.
            const double rounding = 1e-5 + 1e-6 / c.height;
            assert_close(1.0 / fixture.cell_values[cell].w, c.angle, rounding * c.angle);
            inside += place[0] >= s0 && place[1] >= t0;
        }
        const double share = light_angle(&part, c.rectangle, c.point) / c.angle;
        assert_close((double)inside / CELLS, share, SHARE_EPSILON);
    }
    assert_true(near > CASES / 2);
}

// Asks for the densities of rays cell_dirs from cell_points that hit the light, into out [CELLS]: x
// density, y cosine at the light.
static void find_hit_densities(float4 *out)
{
    struct fixture *f = &fixture;
    const uint32_t count = CELLS;
    const struct kernel_arg args[] = {ARG_BUFFER(&f->lights), ARG_BUFFER(&f->shapes),
                                      ARG_BUFFER(&f->points), ARG_BUFFER(&f->dirs),
                                      ARG_VALUE(count),       ARG_BUFFER(&f->values)};
    assert_ok(buffer_write(f->gpu, &f->dirs, f->cell_dirs, CELLS * sizeof(float4)));
    DEVICE_RUN(f->gpu, &f->program, "light_hit_densities", args, count);
    assert_ok(buffer_read(f->gpu, &f->values, out, CELLS * sizeof(float4)));
}

// What a ray that hits the light is said to have is what the sampler has, near and far.
static void hits_have_the_density_of_samples(void **state)
{
    device_of(state);
    struct fixture *f = &fixture;
    uint64_t seed = 2;
    for (int i = 0; i < CASES; i++) {
        struct near_case c = make_case(i, &seed);
        if (i % 3 == 0) {
            random_point(c.point, c.normal, 1.0, &seed);
            c.height = 1.0;
        }
        set_point(c.point);
        draw_samples(&c.light, (float4){0.0f, 0.0f, 0.0f, 0.0f});
        float4 *hits = f->eight_values;
        find_hit_densities(hits);
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            // The cosine of a ray that grazes has few digits.
            const double density = f->cell_values[cell].w;
            const double epsilon = DENSITY_EPSILON + 1e-6 / hits[cell].y;
            assert_close(hits[cell].x, density, epsilon * density);
        }
    }
}

// The density of hits, integrated over the directions to a grid of places on the light.
static void densities_of_hits_integrate_to_one(void **state)
{
    device_of(state);
    struct fixture *f = &fixture;
    uint64_t seed = 3;
    for (int i = 0; i < CASES; i++) {
        struct near_case c = make_case(i, &seed);
        random_point(c.point, c.normal, 1.0, &seed);
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            double s = ((double)(cell % GRID) + 0.5) / GRID;
            double t = ((double)(cell / GRID) + 0.25 + 0.5 * (cell & 1)) / GRID; // off the fold
            if (!c.rectangle && s + t > 1.0) {
                s = 1.0 - s;
                t = 1.0 - t;
            }
            double way[3];
            for (int k = 0; k < 3; k++)
                way[k] = (&c.light.light.org_range.x)[k] + s * (&c.light.shape.edge_u.x)[k] +
                         t * (&c.light.shape.edge_v.x)[k] - c.point[k];
            const double d = vec3_length(way);
            f->cell_dirs[cell] =
                (float4){(float)(way[0] / d), (float)(way[1] / d), (float)(way[2] / d), (float)d};
        }
        set_point(c.point);
        write_light(&c.light);
        find_hit_densities(f->cell_values);
        double sum = 0.0;
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            const double d = f->cell_dirs[cell].w;
            sum += f->cell_values[cell].x * f->cell_values[cell].y * c.light.shape.edge_u.w /
                   (d * d * CELLS);
        }
        assert_close(sum, 1.0, INTEGRAL);
    }
}

// Cuts off what of a polygon is below a plane through the origin (I. Sutherland, G. Hodgman).
// Returns how many corners are left.
static int clip(double out[CORNERS][3], double corners[][3], int count, const double *normal)
{
    int left = 0;
    for (int i = 0; i < count; i++) {
        const double *a = corners[i];
        const double *b = corners[(i + 1) % count];
        const double above_a = vec3_dot(a, normal);
        const double above_b = vec3_dot(b, normal);
        if (above_a >= 0.0)
            memcpy(out[left++], a, sizeof(double[3]));
        if ((above_a >= 0.0) != (above_b >= 0.0)) {
            const double part = above_a / (above_a - above_b);
            for (int k = 0; k < 3; k++)
                out[left][k] = a[k] + part * (b[k] - a[k]);
            left++;
        }
    }
    return left;
}

// Irradiance at the origin from a polygon of radiance 1 (J. H. Lambert, Photometria, 1760): half
// the sum over its edges of angle times cosine between the edge's plane and the surface.
static double lambert_irradiance(double corners[][3], int count, const double *normal)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        const double *a = corners[i];
        const double *b = corners[(i + 1) % count];
        double cross[3];
        vec3_cross(cross, a, b);
        const double length = vec3_length(cross);
        if (length > 0.0)
            sum += atan2(length, vec3_dot(a, b)) * vec3_dot(cross, normal) / length;
    }
    return 0.5 * fabs(sum);
}

// What a surface at the case's point with this normal gets from its light of radiance 1.
static double exact_irradiance(const struct near_case *c, const double *normal)
{
    static const double places[4][2] = {{0.0, 0.0}, {1.0, 0.0}, {1.0, 1.0}, {0.0, 1.0}};
    double corners[4][3], above[CORNERS][3];
    int count = 0;
    for (int i = 0; i < 4; i++) {
        if (i == 2 && !c->rectangle)
            continue;
        for (int k = 0; k < 3; k++)
            corners[count][k] = (&c->light.light.org_range.x)[k] +
                                places[i][0] * (&c->light.shape.edge_u.x)[k] +
                                places[i][1] * (&c->light.shape.edge_v.x)[k] - c->point[k];
        count++;
    }
    count = clip(above, corners, count, normal);
    return lambert_irradiance(above, count, normal);
}

// A surface in any position, as often as not one that meets the light's plane at a right angle: the
// mean is exact, and no sample is brighter than a hemisphere of the light.
static void irradiance_is_lamberts_and_no_sample_outshines_it(void **state)
{
    device_of(state);
    uint64_t seed = 4;
    for (int i = 0; i < CASES; i++) {
        const struct near_case c = make_case(i, &seed);
        double normal[3];
        for (int k = 0; k < 3; k++)
            normal[k] = random_between(&seed, -1.0, 1.0);
        const double off = vec3_dot(normal, c.normal);
        for (int k = 0; k < 3; k++)
            normal[k] -= i % 3 ? off * c.normal[k] : 0.0;
        const double length = vec3_length(normal);
        for (int k = 0; k < 3; k++)
            normal[k] /= length;
        sample_case(&c);
        double sum = 0.0;
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            double dir[3];
            vec3_load(dir, &fixture.cell_dirs[cell].x);
            const double value = fmax(vec3_dot(dir, normal), 0.0) / fixture.cell_values[cell].w;
            assert_true(value <= HEMISPHERE);
            sum += value / CELLS;
        }
        const double exact = exact_irradiance(&c, normal);
        assert_close(sum, exact, INTEGRAL * fmax(exact, 0.05));
    }
}

// A surface that a light is wholly below gets nothing, and its samples need no care; all other
// surfaces see the same samples as a point does.
static void surfaces_do_not_change_what_is_above_them(void **state)
{
    device_of(state);
    struct fixture *f = &fixture;
    float4 *dirs = calloc(2 * CELLS, sizeof(*dirs));
    float4 *values = dirs + CELLS;
    uint64_t seed = 5;
    for (int i = 0; i < CASES; i++) {
        const struct near_case c = make_case(i, &seed);
        float4 normal = {(float)random_between(&seed, -1.0, 1.0),
                         (float)random_between(&seed, -1.0, 1.0),
                         (float)random_between(&seed, -1.0, 1.0), 0.0f};
        if (i % 5 == 0) // the light's own surface, and the one behind it
            normal = (float4){(float)c.normal[0], (float)c.normal[1], (float)c.normal[2], 0.0f};
        double up[3];
        vec3_load(up, &normal.x);
        sample_case(&c);
        memcpy(dirs, f->cell_dirs, CELLS * sizeof(*dirs));
        memcpy(values, f->cell_values, CELLS * sizeof(*values));
        const bool sees = exact_irradiance(&c, up) > 0.0;
        draw_samples(&c.light, normal);
        for (uint32_t cell = 0; cell < CELLS; cell++) {
            const float4 *dir = &f->cell_dirs[cell];
            if (sees) {
                assert_memory_equal(dir, &dirs[cell], sizeof(*dir));
                assert_memory_equal(&f->cell_values[cell], &values[cell], sizeof(*values));
            } else {
                assert_true(dir->x * up[0] + dir->y * up[1] + dir->z * up[2] < 1e-6);
            }
        }
    }
    free(dirs);
}

// Slivers, and points in the light's plane, on its edges and corners: what comes has a density, and
// lies on the light.
static void degenerate_cases_stay_on_the_light(void **state)
{
    device_of(state);
    static const double places[][3] = {{0.0, 0.0, 0.0},  {1.0, 0.0, 0.0},  {0.5, 0.0, 0.0},
                                       {0.3, 0.3, 0.0},  {0.5, 0.5, 0.0},  {1.5, -0.5, 0.0},
                                       {0.0, 0.0, 1e-7}, {0.3, 0.3, 1e-7}, {0.5, 0.0, 1e-6},
                                       {1.5, 0.0, 1e-6}, {0.3, 0.3, 1e-5}, {0.0, 1.0, 1e-4}};
    static const double widths[] = {1.0, 1e-2, 1e-4, 1e-6};
    for (int i = 0; i < 8; i++)
        for (size_t p = 0; p < sizeof(places) / sizeof(places[0]); p++) {
            struct near_case c = {.rectangle = i & 1, .normal = {0.0, 0.0, 1.0}};
            const float width = (float)widths[i / 2];
            const uint32_t kind =
                LIGHT_TWO_SIDED | (c.rectangle ? LIGHT_RECTANGLE : LIGHT_TRIANGLE);
            c.light.light.color_kind = (float4){2.0f, 3.0f, 4.0f, bits_float(kind)};
            c.light.shape.edge_u = (float4){1.0f, 0.0f, 0.0f, c.rectangle ? width : 0.5f * width};
            c.light.shape.edge_v = (float4){0.0f, width, 0.0f, bits_float(0)};
            c.point[0] = places[p][0];
            c.point[1] = places[p][1] * width;
            c.point[2] = (float)places[p][2];
            sample_case(&c);
            for (uint32_t cell = 0; cell < CELLS; cell++) {
                const float4 value = fixture.cell_values[cell];
                if (value.x == 0.0f)
                    continue;
                double place[3];
                find_place(place, &c, &fixture.cell_dirs[cell]);
                assert_true(value.w > 0.0f && isfinite(value.w) && isfinite(1.0f / value.w));
                assert_close(place[0], 0.5, 0.5 + PLACE_EPSILON);
                assert_close(place[1] * width, 0.5 * width, 0.5 * width + PLACE_EPSILON);
            }
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samples_are_even_in_solid_angle),
        cmocka_unit_test(hits_have_the_density_of_samples),
        cmocka_unit_test(densities_of_hits_integrate_to_one),
        cmocka_unit_test(irradiance_is_lamberts_and_no_sample_outshines_it),
        cmocka_unit_test(surfaces_do_not_change_what_is_above_them),
        cmocka_unit_test(degenerate_cases_stay_on_the_light),
    };
    return cmocka_run_group_tests(tests, light_setup, light_teardown);
}
