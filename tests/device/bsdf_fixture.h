/**
 * @file
 * Evaluates and samples BSDFs on the device, and integrates over the sphere on the host.
 */
#ifndef TESTS_DEVICE_BSDF_FIXTURE_H
#define TESTS_DEVICE_BSDF_FIXTURE_H

#include <math.h>
#include <stdbool.h>

#include "bsdf_case.h"
#include "prep/prep_support.h"
#include "prep/vec3.h"
#include "support.h"

#define RINGS   512u // of the grid over the sphere, about the mirrored view
#define SPOKES  256u
#define CELLS   (RINGS * SPOKES)
#define SAMPLES (1u << 16)
#define DIRS    64u // directions that are paired with each other
#define PI      3.14159265358979323846

// Error of integrals over the grid: the ring that the horizon cuts counts whole or not at all, half
// of its 0.012 rad.
#define GRID_EPSILON 6e-3
#define SIGMAS       6.0 // how far a mean may be from what it estimates

#define COUNT(array) (sizeof(array) / sizeof((array)[0]))

/** What is evaluated of a case's material. */
enum model {
    MODEL_GLTF,
    MODEL_PHONG,
    MODEL_LANES, // glTF's, of hits side by side
    MODEL_SHEEN,
    MODEL_COUNT
};

/** Those of whole materials. */
static const enum model models[] = {MODEL_GLTF, MODEL_PHONG, MODEL_LANES};

/** The group's state. */
struct fixture {
    struct gpu *gpu;
    struct program programs[MODEL_COUNT];
    struct buffer dirs, values;                     // [CELLS] float4
    struct buffer numbers;                          // [SAMPLES] float4, uniform
    struct buffer draws;                            // [SAMPLES]
    float4 *cell_dirs, *cell_values, *draw_numbers; // the host's copies
    double *cell_sizes;                             // [CELLS] sr
    struct bsdf_draw *cell_draws;
    float2 turns[SPOKES]; // cosine and sine of each spoke
};

static inline struct fixture make_fixture(struct gpu *gpu)
{
    struct fixture f = {.gpu = gpu};
    for (int model = 0; model < MODEL_COUNT; model++) {
        const struct program_options options = {.brdf_phong = model == MODEL_PHONG,
                                                .layers = model == MODEL_SHEEN,
                                                .sheen = model == MODEL_SHEEN};
        f.programs[model] =
            device_program(gpu, model == MODEL_LANES ? "bsdf_lanes" : "bsdf", &options);
    }
    f.cell_dirs = calloc(CELLS, sizeof(*f.cell_dirs));
    f.cell_values = calloc(CELLS, sizeof(*f.cell_values));
    f.cell_sizes = calloc(CELLS, sizeof(*f.cell_sizes));
    f.cell_draws = calloc(SAMPLES, sizeof(*f.cell_draws));
    f.draw_numbers = calloc(SAMPLES, sizeof(*f.draw_numbers));
    for (uint32_t i = 0; i < SPOKES; i++) {
        const double phi = 2.0 * PI * (i + 0.5) / SPOKES;
        f.turns[i] = (float2){(float)cos(phi), (float)sin(phi)};
    }
    uint64_t seed = 1;
    for (uint32_t i = 0; i < SAMPLES; i++)
        f.draw_numbers[i] = (float4){(float)(random_unit(&seed) * 0.9999999),
                                     (float)(random_unit(&seed) * 0.9999999),
                                     (float)(random_unit(&seed) * 0.9999999), 0.0f};
    f.dirs = device_buffer(gpu, NULL, CELLS * sizeof(float4));
    f.values = device_buffer(gpu, NULL, CELLS * sizeof(float4));
    f.numbers = device_buffer(gpu, f.draw_numbers, SAMPLES * sizeof(float4));
    f.draws = device_buffer(gpu, NULL, SAMPLES * sizeof(struct bsdf_draw));
    return f;
}

static inline void release_fixture(struct fixture *f)
{
    buffer_free(f->gpu, &f->draws);
    buffer_free(f->gpu, &f->numbers);
    buffer_free(f->gpu, &f->values);
    buffer_free(f->gpu, &f->dirs);
    free(f->draw_numbers);
    free(f->cell_draws);
    free(f->cell_sizes);
    free(f->cell_values);
    free(f->cell_dirs);
    for (int model = 0; model < MODEL_COUNT; model++)
        program_free(&f->programs[model]);
}

/** Evaluates count <= CELLS directions: rgb f cos, w density. */
static inline void evaluate(const struct fixture *f, enum model model, const struct bsdf_case *c,
                            const float4 *dirs, uint32_t count, float4 *out)
{
    struct buffer case_buffer = device_buffer(f->gpu, c, sizeof(*c));
    const struct kernel_arg args[] = {ARG_BUFFER(&case_buffer), ARG_BUFFER(&f->dirs),
                                      ARG_VALUE(count), ARG_BUFFER(&f->values)};
    assert_ok(buffer_write(f->gpu, &f->dirs, dirs, count * sizeof(*dirs)));
    DEVICE_RUN(f->gpu, &f->programs[model], "bsdf_values", args, count);
    assert_ok(buffer_read(f->gpu, &f->values, out, count * sizeof(*out)));
    buffer_free(f->gpu, &case_buffer);
}

/** Draws SAMPLES directions into cell_draws. */
static inline void draw(struct fixture *f, enum model model, const struct bsdf_case *c)
{
    struct buffer case_buffer = device_buffer(f->gpu, c, sizeof(*c));
    const uint32_t count = SAMPLES;
    const struct kernel_arg args[] = {ARG_BUFFER(&case_buffer), ARG_BUFFER(&f->numbers),
                                      ARG_VALUE(count), ARG_BUFFER(&f->draws)};
    DEVICE_RUN(f->gpu, &f->programs[model], "bsdf_draws", args, count);
    assert_ok(buffer_read(f->gpu, &f->draws, f->cell_draws, SAMPLES * sizeof(*f->cell_draws)));
    buffer_free(f->gpu, &case_buffer);
}

/** The group's own set-up and clean-up, around those of the device. */
static struct fixture fixture;

static inline int bsdf_setup(void **state)
{
    if (device_setup(state) != 0)
        return -1;
    if (*state != NULL)
        fixture = make_fixture(*state);
    return 0;
}

static inline int bsdf_teardown(void **state)
{
    if (*state != NULL)
        release_fixture(&fixture);
    return device_teardown(state);
}

// ---- directions

/** Two vectors that make a frame with the unit vector n. */
static inline void frame(double *t, double *b, const double *n)
{
    const double up[3] = {fabs(n[0]) < 0.5, fabs(n[0]) >= 0.5, 0.0};
    vec3_cross(t, up, n);
    const double length = vec3_length(t);
    for (int k = 0; k < 3; k++)
        t[k] /= length;
    vec3_cross(b, n, t);
}

static inline void vec3_of(double *out, const float4 v)
{
    out[0] = v.x;
    out[1] = v.y;
    out[2] = v.z;
}

static inline float4 float4_of(const double *v)
{
    return (float4){(float)v[0], (float)v[1], (float)v[2], 0.0f};
}

/** The view mirrored at the shading normal: where the grid has its pole. */
static inline void mirrored_view(double *out, const struct bsdf_case *c)
{
    double n[3], v[3];
    vec3_of(n, c->normal);
    vec3_of(v, c->view);
    for (int k = 0; k < 3; k++)
        out[k] = 2.0 * vec3_dot(n, v) * n[k] - v[k];
    const double length = vec3_length(out);
    for (int k = 0; k < 3; k++)
        out[k] /= length;
}

/** Evaluates the grid's cells, whose rings grow with the cube of their number: narrow lobes are
 * met by many. */
static inline void evaluate_sphere(struct fixture *f, enum model model, const struct bsdf_case *c)
{
    double pole[3], t[3], b[3];
    mirrored_view(pole, c);
    frame(t, b, pole);
    for (uint32_t ring = 0; ring < RINGS; ring++) {
        const double s = (ring + 0.5) / RINGS;
        const double theta = PI * s * s * s;
        const double x = sin(theta);
        const double z = cos(theta);
        for (uint32_t spoke = 0; spoke < SPOKES; spoke++) {
            const float2 turn = f->turns[spoke];
            const uint32_t i = ring * SPOKES + spoke;
            double dir[3];
            for (int k = 0; k < 3; k++)
                dir[k] = x * (turn.x * t[k] + turn.y * b[k]) + z * pole[k];
            f->cell_dirs[i] = float4_of(dir);
            f->cell_sizes[i] = x * 3.0 * PI * s * s / RINGS * 2.0 * PI / SPOKES;
        }
    }
    evaluate(f, model, c, f->cell_dirs, CELLS, f->cell_values);
}

/** The integral of the evaluated grid's red: what of evenly incoming light is reflected. */
static inline double grid_albedo(const struct fixture *f)
{
    double sum = 0.0;
    for (uint32_t i = 0; i < CELLS; i++)
        sum += f->cell_values[i].x * f->cell_sizes[i];
    return sum;
}

/** A hit seen from `cosine` to its normal; `tilt` turns the geometric normal aside. */
static inline struct bsdf_case make_case(double cosine, double tilt)
{
    const double n[3] = {0.36, -0.48, 0.8};
    double t[3], b[3], view[3], geometric[3];
    frame(t, b, n);
    for (int k = 0; k < 3; k++) {
        view[k] = cosine * n[k] + sqrt(1.0 - cosine * cosine) * t[k];
        geometric[k] = cos(tilt) * n[k] + sin(tilt) * b[k];
    }
    return (struct bsdf_case){
        .normal = float4_of(n), .geometric = float4_of(geometric), .view = float4_of(view)};
}

/** A metallic-roughness material of one grey. */
static inline struct material make_material(float base, float metallic, float roughness)
{
    return (struct material){.base = {base, base, base, 1.0f},
                             .specular = {1.0f, 1.0f, 1.0f, 1.0f},
                             .metallic = metallic,
                             .roughness = roughness};
}

/** Calls a check for four views, five roughnesses, three metalnesses and all models of materials.
 */
static inline void for_all_cases(void (*check)(enum model model, const struct bsdf_case *c),
                                 double tilt)
{
    static const double cosines[] = {1.0, 0.7, 0.25, 0.05};
    static const float roughnesses[] = {0.0f, 0.1f, 0.3f, 0.6f, 1.0f};
    static const float metalnesses[] = {0.0f, 0.5f, 1.0f};
    for (size_t view = 0; view < COUNT(cosines); view++) {
        for (size_t i = 0; i < COUNT(roughnesses) * COUNT(metalnesses); i++) {
            struct bsdf_case c = make_case(cosines[view], tilt);
            c.material = make_material(0.8f, metalnesses[i % COUNT(metalnesses)],
                                       roughnesses[i / COUNT(metalnesses)]);
            for (size_t m = 0; m < COUNT(models); m++)
                check(models[m], &c);
        }
    }
}

/** Makes DIRS directions above the surface, not quite down to its horizon, where f is divided by
 * little. */
static inline void make_dirs(float4 *out, const struct bsdf_case *c, uint64_t *seed)
{
    double n[3], t[3], b[3], dir[3];
    vec3_of(n, c->normal);
    frame(t, b, n);
    for (uint32_t i = 0; i < DIRS; i++) {
        const double z = random_between(seed, 0.05, 1.0);
        const double phi = random_between(seed, 0.0, 2.0 * PI);
        const double r = sqrt(1.0 - z * z);
        for (int k = 0; k < 3; k++)
            dir[k] = r * (cos(phi) * t[k] + sin(phi) * b[k]) + z * n[k];
        out[i] = float4_of(dir);
    }
}

/** The cosine of a direction to the normal. */
static inline double cosine_of(const struct bsdf_case *c, const float4 dir)
{
    double n[3], d[3];
    vec3_of(n, c->normal);
    vec3_of(d, dir);
    return vec3_dot(n, d);
}

/**
 * f(a, b) = f(b, a), or f cos is so, for all pairs of directions [DIRS].
 *
 * @param hit                 Its view is not looked at.
 * @param divided             What is symmetric is f, without the light's cosine.
 * @param relative, absolute  By how much both may differ.
 */
static inline void check_both_ways(const struct fixture *f, enum model model,
                                   const struct bsdf_case *hit, bool divided, const float4 *dirs,
                                   double relative, double absolute)
{
    static float4 values[DIRS][DIRS];
    struct bsdf_case c = *hit;
    for (uint32_t i = 0; i < DIRS; i++) {
        c.view = dirs[i];
        evaluate(f, model, &c, dirs, DIRS, values[i]);
    }
    for (uint32_t i = 0; i < DIRS; i++) {
        for (uint32_t j = 0; j < i; j++) {
            const double a = values[i][j].x * (divided ? cosine_of(&c, dirs[i]) : 1.0);
            const double b = values[j][i].x * (divided ? cosine_of(&c, dirs[j]) : 1.0);
            assert_close(a, b, relative * a + absolute);
        }
    }
}

#endif
