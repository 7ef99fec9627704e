// Light from far away against closed forms: furnaces, directions, depth, and both ways to it.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "gltf_writer.h"
#include "render_support.h"

#define PI        3.14159265358979323846
#define RADIANCE  2.0
#define ALBEDO    0.6
#define TOLERANCE 1e-3 // relative: float sums, and normals of 32 bits
#define SEEDS     16

static void set_background(struct lk_settings *settings, float radiance)
{
    for (int k = 0; k < 3; k++)
        settings->background[k] = radiance;
}

// A level plane seen from above.
static struct lk_scene *make_plane(void)
{
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, ALBEDO), 0.0f, 10.0f, true);
    gltf_camera_flat(&writer, "down", (const float[]){0.1f, 2.0f, 0.1f},
                     (const float[]){0.1f, 0.0f, 0.1f}, 0.5);
    gltf_camera_flat(&writer, "up", (const float[]){0.1f, 2.0f, 0.1f},
                     (const float[]){0.1f, 9.0f, 0.1f}, 0.5);
    return gltf_load(&writer);
}

// ---- One radiance all around

static void background_is_seen_and_lights_a_plane(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_plane();
    for (uint32_t depth = 1; depth <= 3; depth += 2) {
        struct lk_settings settings = test_settings(24, 24, 64);
        settings.depth = depth;
        set_background(&settings, RADIANCE);
        assert_agrees("plane", estimate_point(scene, &settings), ALBEDO * RADIANCE, TOLERANCE);
        settings.camera = "up";
        assert_agrees("sky", estimate_point(scene, &settings), RADIANCE, TOLERANCE);

        settings.quantity = LK_IRRADIANCE;
        assert_true(render_mean(scene, &settings) == 0.0);
        settings.camera = "down";
        assert_agrees("irradiance", estimate_point(scene, &settings), PI * RADIANCE, TOLERANCE);
    }
    lk_scene_free(scene);
}

// Surfaces that see the sky alone send back their albedo, whatever the share of bounces and light
// samples in it; a white metal's is what its microfacets do not lose, found by bounces alone in
// rooms that emit (tests/engine/test_furnace.c), so here smooth ones do.
static void convex_bodies_are_furnaces(void **state)
{
    (void)state;
    skip_without_device();
    const double roughness[] = {0.02, 0.1, 0.3};
    for (int i = 0; i < 3; i++) {
        struct gltf_writer writer = {0};
        const int metal = gltf_material(
            &writer,
            "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,1],\"roughnessFactor\":%g}}",
            roughness[i]);
        gltf_floor(&writer, metal, 0.0f, 10.0f, true);
        gltf_camera_flat(&writer, "down", (const float[]){0.1f, 2.0f, 0.9f},
                         (const float[]){0.1f, 0.0f, 0.1f}, 0.2);
        struct lk_scene *scene = gltf_load(&writer);
        struct lk_settings settings = test_settings(32, 32, 64);
        settings.depth = 1;
        set_background(&settings, RADIANCE);
        assert_agrees("metal", estimate_point(scene, &settings), RADIANCE, 0.01);
        lk_scene_free(scene);
    }
}

static void phong_mirrors_show_the_sky(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    const int mirror = gltf_material(
        &writer, "{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":"
                 "[0,0,0,1],\"specularFactor\":[0.5,0.5,0.5],\"glossinessFactor\":1}}}");
    gltf_floor(&writer, mirror, 0.0f, 10.0f, true);
    gltf_camera_flat(&writer, "down", (const float[]){0.1f, 2.0f, 0.9f},
                     (const float[]){0.1f, 0.0f, 0.1f}, 0.2);
    struct lk_scene *scene = gltf_load(&writer);
    struct lk_settings settings = test_settings(8, 8, 8);
    settings.depth = 1;
    settings.brdf = LK_BRDF_PHONG;
    set_background(&settings, RADIANCE);
    assert_agrees("mirror", estimate_point(scene, &settings), 0.5 * RADIANCE, TOLERANCE);
    lk_scene_free(scene);
}

// ---- Images

// Writes an image that is black but for one texel of radiance 1000, and asks for it.
static void ask_for_spot(struct lk_settings *settings, uint32_t column, uint32_t row)
{
    static char path[64];
    float rgb[64 * 32 * 3] = {0};
    for (int k = 0; k < 3; k++)
        rgb[3 * (row * 64 + column) + k] = 1000.0f;
    snprintf(path, sizeof(path), "/tmp/lightkiln_%d.pfm", (int)getpid());
    FILE *file = fopen(path, "wb");
    assert_non_null(file);
    fprintf(file, "PF\n64 32\n-1.0\n");
    for (int y = 31; y >= 0; y--) // rows from the bottom
        assert_int_equal(fwrite(rgb + (size_t)y * 64 * 3, sizeof(float), 64 * 3, file), 64 * 3);
    fclose(file);
    settings->env = path;
}

// Looks in six directions along the level and finds where the light is.
static double look(double azimuth, const struct lk_settings *settings)
{
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), -50.0f, 1.0f, true);
    gltf_camera(&writer, "level", (const float[]){0, 0, 0},
                (const float[]){(float)sin(azimuth), 0.0f, (float)-cos(azimuth)}, 0.3);
    struct lk_scene *scene = gltf_load(&writer);
    const double mean = render_mean(scene, settings);
    lk_scene_free(scene);
    return mean;
}

static void the_middle_looks_along_minus_z_and_turns_with_rotation(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(16, 16, 4);
    settings.depth = 1;
    ask_for_spot(&settings, 32, 16); // just to the right of the middle
    assert_true(look(0.0, &settings) > 1.0);
    assert_true(look(PI / 2.0, &settings) == 0.0);
    assert_true(look(PI, &settings) == 0.0);

    ask_for_spot(&settings, 48, 16); // three quarters: +X
    assert_true(look(PI / 2.0, &settings) > 1.0);
    assert_true(look(-PI / 2.0, &settings) == 0.0);

    // A quarter counter-clockwise from above takes +X to -Z.
    settings.env_rotation_deg = 90.0f;
    assert_true(look(0.0, &settings) > 1.0);
    assert_true(look(PI / 2.0, &settings) == 0.0);
    settings.env_rotation_deg = -90.0f;
    assert_true(look(PI, &settings) > 1.0);
    unlink(settings.env);
}

// A small bright spot is met by light samples nearly always; the plane's irradiance is its radiance
// times solid angle and cosine, whichever way the map is turned.
static void a_spot_gives_its_solid_angle_times_the_cosine(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_plane();
    const uint32_t row = 9;
    const double step = PI / 32.0;
    double exact = 0.0; // the filter spreads the texel over a tent of two texels' width each way
    const int steps = 400;
    for (int i = 0; i < steps; i++) {
        const double at = row - 0.5 + 2.0 * (i + 0.5) / steps;
        const double weight = 1.0 - fabs(at - row - 0.5);
        exact += weight * sin(at * step) * cos(at * step) * step * 2.0 / steps;
    }
    exact *= 1000.0 * 2.0 * PI / 64.0;
    for (int turn = 0; turn < 3; turn++) {
        struct lk_settings settings = test_settings(24, 24, 16);
        ask_for_spot(&settings, 10, row);
        settings.quantity = LK_IRRADIANCE;
        settings.depth = turn == 2 ? 3 : 1;
        settings.env_rotation_deg = 100.0f * (float)turn;
        assert_agrees("irradiance", estimate_point(scene, &settings), exact, 0.003);
        settings.env_strength = 0.25f;
        assert_agrees("a quarter", estimate_point(scene, &settings), 0.25 * exact, 0.003);
        unlink(settings.env);
    }
    lk_scene_free(scene);
}

// Light samples and bounces share the work; with mirrors of any width the mean is that of bounces
// alone, which a depth with one more hit gives: nothing else lights the scene.
static void both_ways_to_the_sky_sum_to_one(void **state)
{
    (void)state;
    skip_without_device();
    const double roughness[] = {0.15, 0.4, 1.0};
    for (int i = 0; i < 3; i++) {
        struct estimate seen[2];
        for (int way = 0; way < 2; way++) {
            // The same surface, lit by a sky or by a large dome that emits as much.
            struct gltf_writer writer = {0};
            const int floor =
                gltf_material(&writer,
                              "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.8,0.8,1],"
                              "\"metallicFactor\":0.5,\"roughnessFactor\":%g}}",
                              roughness[i]);
            gltf_floor(&writer, floor, 0.0f, 1.0f, true);
            if (way == 1)
                gltf_room(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false),
                          (const float[]){-9, -9, -9}, (const float[]){9, 9, 9});
            gltf_camera_flat(&writer, "down", (const float[]){0.1f, 2.0f, 1.9f},
                             (const float[]){0.1f, 0.0f, 0.1f}, 0.2);
            struct lk_scene *scene = gltf_load(&writer);
            struct lk_settings settings = test_settings(32, 32, 32);
            settings.depth = 2;
            if (way == 0)
                set_background(&settings, RADIANCE);
            seen[way] = estimate_image(scene, &settings, SEEDS);
            lk_scene_free(scene);
        }
        assert_same_mean("sky and dome", seen[0], seen[1]);
    }
}

// ---- Sky

static void the_sun_of_a_sky_shines_from_where_it_is(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, ALBEDO), 0.0f, 10.0f, true);
    gltf_quad(&writer, gltf_lambert(&writer, 0.0), // a wall to the east, double-sided to light
              (const float[]){1, 0, -9, 1, 0, 9, 1, 9, 9, 1, 9, -9});
    gltf_camera_flat(&writer, "down", (const float[]){0.0f, 2.0f, 0.0f},
                     (const float[]){0.0f, 0.0f, 0.0f}, 0.1);
    struct lk_scene *scene = gltf_load(&writer);
    struct lk_settings settings = test_settings(16, 16, 16);
    settings.quantity = LK_IRRADIANCE;
    settings.depth = 1;
    settings.sky_sun_deg[1] = 30.0f;
    settings.sky_sun_deg[0] = 90.0f;
    const double behind_wall = render_mean(scene, &settings);
    settings.sky_sun_deg[0] = -90.0f;
    const double open = render_mean(scene, &settings);
    assert_true(open > 30000.0 && behind_wall < 0.4 * open);
    lk_scene_free(scene);
}

// ---- The file's own

#define FACE 16 // texels on a side

// Linear value of a byte of a face.
static double linear_of(int byte)
{
    const double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

// A quarter of a face: its red and green name it, its alpha divides.
static void quarter_color(uint8_t *out, int face, int right, int down)
{
    out[0] = (uint8_t)(60 + 30 * face);
    out[1] = (uint8_t)(40 + 90 * right + 45 * down);
    out[2] = 100;
    out[3] = (uint8_t)(face % 2 ? 255 : 51);
}

// A scene with a cube of quarters, seen from its middle along a direction.
static struct lk_scene *make_cube(const double *dir, const char *members)
{
    static uint8_t texels[6][FACE * FACE * 4];
    const uint8_t *faces[6];
    for (int face = 0; face < 6; face++) {
        for (int i = 0; i < FACE * FACE; i++)
            quarter_color(&texels[face][i * 4], face, i % FACE >= FACE / 2, i / FACE >= FACE / 2);
        faces[face] = texels[face];
    }
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), -90.0f, 0.1f, true);
    gltf_image_light(&writer, faces, FACE, members);
    gltf_camera(&writer, "view", (const float[]){0, 0, 0},
                (const float[]){(float)dir[0], (float)dir[1], (float)dir[2]}, 1e-3);
    return gltf_load(&writer);
}

static void check_quarter(const double *dir, const char *members, int face, int right, int down,
                          double intensity)
{
    struct lk_scene *scene = make_cube(dir, members);
    struct lk_settings settings = test_settings(2, 2, 1);
    const struct rgb seen = render_rgb(scene, &settings);
    uint8_t color[4];
    quarter_color(color, face, right, down);
    for (int k = 0; k < 3; k++)
        assert_agrees("quarter", (struct estimate){seen.v[k], 0.0},
                      intensity * linear_of(color[k]) / (color[3] / 255.0), TOLERANCE);
    lk_scene_free(scene);
}

// Faces show what is seen from within: forward, and what is up in the picture.
static const double forward[6][3] = {{1, 0, 0},  {-1, 0, 0}, {0, 1, 0},
                                     {0, -1, 0}, {0, 0, 1},  {0, 0, -1}};
static const double upward[6][3] = {{0, 1, 0}, {0, 1, 0}, {0, 0, -1},
                                    {0, 0, 1}, {0, 1, 0}, {0, 1, 0}};

static void a_files_cube_is_seen_from_within(void **state)
{
    (void)state;
    skip_without_device();
    for (int face = 0; face < 6; face++)
        for (int quarter = 0; quarter < 4; quarter++) {
            const double *f = forward[face];
            const double *u = upward[face];
            const double across[3] = {f[1] * u[2] - f[2] * u[1], f[2] * u[0] - f[0] * u[2],
                                      f[0] * u[1] - f[1] * u[0]};
            const double x = quarter % 2 ? 0.5 : -0.5;
            const double y = quarter / 2 ? -0.5 : 0.5;
            double dir[3], turned[3];
            for (int k = 0; k < 3; k++)
                dir[k] = f[k] + x * across[k] + y * u[k];
            check_quarter(dir, "", face, quarter % 2, quarter / 2, 1.0);

            // A quarter turn about +X takes +Y to +Z.
            turned[0] = dir[0];
            turned[1] = -dir[2];
            turned[2] = dir[1];
            check_quarter(turned, ",\"rotation\":[0.70710678,0,0,0.70710678],\"intensity\":3", face,
                          quarter % 2, quarter / 2, 3.0);
        }
}

static void what_is_asked_for_replaces_the_files_own(void **state)
{
    (void)state;
    skip_without_device();
    const double dir[3] = {0.5, 0.5, -1.0};
    struct lk_scene *scene = make_cube(dir, "");
    struct lk_settings settings = test_settings(2, 2, 1);
    const double own = render_mean(scene, &settings);
    set_background(&settings, RADIANCE);
    assert_agrees("background", (struct estimate){render_mean(scene, &settings), 0.0}, RADIANCE,
                  TOLERANCE);
    set_background(&settings, 0.0f);
    settings.env_strength = 2.0f;
    assert_agrees("strength", (struct estimate){render_mean(scene, &settings), 0.0}, 2.0 * own,
                  TOLERANCE);
    settings.env_strength = 0.0f;
    assert_true(own > 0.0 && render_mean(scene, &settings) == 0.0);
    lk_scene_free(scene);
}

// The memory table holds the environment: 24 bytes a texel.
static void info_counts_the_environment(void **state)
{
    (void)state;
    const double dir[3] = {0, 0, -1};
    struct lk_scene *plane = make_plane();
    struct lk_scene *cube = make_cube(dir, "");
    struct lk_settings settings = test_settings(8, 8, 1);
    struct lk_scene_info info;
    assert_int_equal(lk_scene_info(&info, plane, &settings), LK_OK);
    const uint64_t without = info.memory.lights;
    assert_int_equal(lk_scene_info(&info, cube, &settings), LK_OK);
    assert_int_equal(info.memory.lights - without, 24 * 4 * FACE * 2 * FACE);
    set_background(&settings, 1.0f);
    assert_int_equal(lk_scene_info(&info, plane, &settings), LK_OK);
    assert_int_equal(info.memory.lights - without, 24);
    lk_scene_free(plane);
    lk_scene_free(cube);
}

// ---- Refusals

static void settings_that_make_no_environment_are_refused(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_plane();
    struct lk_image *image = NULL;
    struct lk_settings settings = test_settings(8, 8, 1);
    settings.env = "/nowhere/sky.hdr";
    assert_int_equal(lk_render(&image, scene, &settings, NULL), LK_IO);
    assert_non_null(strstr(lk_error(), "/nowhere/sky.hdr"));
    settings.background[1] = 1.0f;
    assert_int_equal(lk_render(&image, scene, &settings, NULL), LK_USAGE);
    settings.env = NULL;
    settings.background[1] = -1.0f;
    assert_int_equal(lk_render(&image, scene, &settings, NULL), LK_USAGE);
    settings.background[1] = 0.0f;
    settings.sky_sun_deg[1] = 91.0f;
    assert_int_equal(lk_render(&image, scene, &settings, NULL), LK_USAGE);
    settings.sky_sun_deg[1] = 0.0f;
    settings.env_strength = NAN;
    assert_int_equal(lk_render(&image, scene, &settings, NULL), LK_USAGE);
    lk_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(background_is_seen_and_lights_a_plane),
        cmocka_unit_test(convex_bodies_are_furnaces),
        cmocka_unit_test(phong_mirrors_show_the_sky),
        cmocka_unit_test(the_middle_looks_along_minus_z_and_turns_with_rotation),
        cmocka_unit_test(a_spot_gives_its_solid_angle_times_the_cosine),
        cmocka_unit_test(both_ways_to_the_sky_sum_to_one),
        cmocka_unit_test(the_sun_of_a_sky_shines_from_where_it_is),
        cmocka_unit_test(a_files_cube_is_seen_from_within),
        cmocka_unit_test(what_is_asked_for_replaces_the_files_own),
        cmocka_unit_test(info_counts_the_environment),
        cmocka_unit_test(settings_that_make_no_environment_are_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
