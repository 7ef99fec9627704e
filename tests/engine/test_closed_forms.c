// Direct light against closed forms: what a point of a plane receives from each kind of light.
//
// The camera is orthographic and sees a spot of a plane so small that every pixel looks at the same
// point; the formulas are those of the point.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "form_factor.h"
#include "see.h"

#define PI        3.14159265358979323846
#define ALBEDO    0.6
#define INTENSITY 50.0 // cd
#define HEIGHT    2.0f // of the lights over the plane, m

// Relative: SPECK / HEIGHT moves E by 1e-4 at most, and the middle of the spot by far less; a
// normal of 32 bits adds 2e-5 of its angle; float rounding the rest.
#define TOLERANCE 2e-4

// A plane at y = 0 seen at (x, 0, 0).
static void add_plane(struct gltf_writer *writer, float x)
{
    gltf_floor(writer, gltf_lambert(writer, ALBEDO), 0.0f, 50.0f, true);
    look_down(writer, x, 0.0f);
}

// What the camera sees of the direct light.
static double see_punctual(struct gltf_writer *writer, enum lk_quantity quantity)
{
    struct lk_settings settings = test_settings(4, 4, 4);
    settings.depth = 1;
    settings.quantity = quantity;
    return see_mean(writer, &settings);
}

// The same of a light with an area, whose samples scatter.
static struct estimate see(struct gltf_writer *writer)
{
    struct lk_settings settings = test_settings(16, 16, 1024);
    settings.depth = 1;
    settings.quantity = LK_IRRADIANCE;
    return see_point(writer, &settings);
}

static void assert_close(const char *what, double value, double exact)
{
    assert_agrees(what, (struct estimate){value, 0.0}, exact, TOLERANCE);
}

// ---- Lights without extent

// E of a point light at (0, HEIGHT, 0) at (x, 0, 0).
static double point_irradiance(double x, double range)
{
    const double distance2 = x * x + HEIGHT * HEIGHT;
    const double ratio = range > 0.0 ? sqrt(distance2) / range : 0.0;
    const double window = fmax(fmin(1.0 - pow(ratio, 4.0), 1.0), 0.0);
    return INTENSITY * HEIGHT / (distance2 * sqrt(distance2)) * window;
}

static double see_point_light(double x, double range, enum lk_quantity quantity)
{
    struct gltf_writer writer = {0};
    char text[32] = "";
    if (range > 0.0)
        snprintf(text, sizeof(text), ",\"range\":%g", range);
    add_plane(&writer, (float)x);
    gltf_light(&writer, (const float[]){0.0f, HEIGHT, 0.0f}, (const float[]){0.0f, 0.0f, 0.0f},
               "{\"type\":\"point\",\"intensity\":%g%s}", INTENSITY, text);
    return see_punctual(&writer, quantity);
}

static void point_light_gives_intensity_cos_over_squared_distance(void **state)
{
    (void)state;
    skip_without_device();
    for (double x = 0.0; x < 20.0; x = 3.0 * x + 0.5) {
        const double exact = point_irradiance(x, 0.0);
        assert_close("irradiance", see_point_light(x, 0.0, LK_IRRADIANCE), exact);
        assert_close("radiance", see_point_light(x, 0.0, LK_RADIANCE), exact * ALBEDO / PI);
    }
}

static void range_windows_a_point_light_and_ends_it(void **state)
{
    (void)state;
    skip_without_device();
    const double range = 4.0;
    for (double x = 0.0; x < 3.4; x += 0.8) // distance 3.77 at the last
        assert_close("within", see_point_light(x, range, LK_IRRADIANCE),
                     point_irradiance(x, range));
    assert_true(see_point_light(3.5, range, LK_IRRADIANCE) == 0.0);
    assert_true(see_point_light(30.0, range, LK_IRRADIANCE) == 0.0);
}

// E of a spot light at (0, HEIGHT, 0) that shines straight down, at (x, 0, 0).
static double spot_irradiance(double x, double inner, double outer)
{
    const double cosine = HEIGHT / sqrt(x * x + HEIGHT * HEIGHT);
    const double scale = 1.0 / fmax(0.001, cos(inner) - cos(outer));
    const double cone = fmin(fmax((cosine - cos(outer)) * scale, 0.0), 1.0);
    return point_irradiance(x, 0.0) * cone * cone;
}

static double see_spot(double x, double inner, double outer)
{
    struct gltf_writer writer = {0};
    add_plane(&writer, (float)x);
    gltf_light(&writer, (const float[]){0.0f, HEIGHT, 0.0f}, (const float[]){0.0f, 0.0f, 0.0f},
               "{\"type\":\"spot\",\"intensity\":%g,\"spot\":{\"innerConeAngle\":%.9g,"
               "\"outerConeAngle\":%.9g}}",
               INTENSITY, inner, outer);
    return see_punctual(&writer, LK_IRRADIANCE);
}

static void spot_falls_off_between_its_cones(void **state)
{
    (void)state;
    skip_without_device();
    const double inner = 0.3;
    const double outer = 0.7;
    const double angles[] = {0.0, 0.29, 0.31, 0.4, 0.5, 0.6, 0.65};
    for (size_t i = 0; i < sizeof(angles) / sizeof(angles[0]); i++) {
        const double x = HEIGHT * tan(angles[i]);
        assert_close("within the outer cone", see_spot(x, inner, outer),
                     spot_irradiance(x, inner, outer));
    }
    assert_true(see_spot(HEIGHT * tan(0.71), inner, outer) == 0.0);
    assert_true(see_spot(HEIGHT * tan(1.2), inner, outer) == 0.0);
}

static void spot_defaults_to_an_eighth_of_a_turn(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    const double x = 0.9;
    add_plane(&writer, (float)x);
    gltf_light(&writer, (const float[]){0.0f, HEIGHT, 0.0f}, (const float[]){0.0f, 0.0f, 0.0f},
               "{\"type\":\"spot\",\"intensity\":%g,\"spot\":{}}", INTENSITY);
    assert_close("default cones", see_punctual(&writer, LK_IRRADIANCE),
                 spot_irradiance(x, 0.0, PI / 4.0));
}

static void directional_light_gives_its_lux_times_the_cosine(void **state)
{
    (void)state;
    skip_without_device();
    const float towards[] = {0.0f, -0.7f, -2.0f, 5.0f};
    for (int i = 0; i < 4; i++) {
        struct gltf_writer writer = {0};
        add_plane(&writer, 0.3f);
        gltf_light(&writer, (const float[]){towards[i], 1.0f, 0.0f}, (const float[]){0, 0, 0},
                   "{\"type\":\"directional\",\"intensity\":3}");
        const double cosine = 1.0 / sqrt(1.0 + (double)towards[i] * towards[i]);
        assert_close("lux", see_punctual(&writer, LK_IRRADIANCE), 3.0 * cosine);
    }
}

static void light_from_behind_the_plane_does_not_arrive(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    add_plane(&writer, 0.0f);
    gltf_light(&writer, (const float[]){0.1f, -1.0f, 0.0f}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":100}");
    gltf_light(&writer, (const float[]){0.1f, -1.0f, 0.0f}, (const float[]){0, 0, 0},
               "{\"type\":\"directional\",\"intensity\":100}");
    assert_true(see_punctual(&writer, LK_RADIANCE) == 0.0);
}

// ---- Surfaces that emit

#define RADIANCE 7.0

static void rectangle_overhead_gives_its_form_factor(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    add_plane(&writer, 0.0f);
    const int material = gltf_emitter(&writer, 0.0, RADIANCE, false);
    gltf_quad(&writer, material,
              (const float[]){0, HEIGHT, 0, 3, HEIGHT, 0, 3, HEIGHT, 1.5f, 0, HEIGHT, 1.5f});
    assert_agrees("E", see(&writer), RADIANCE * PI * form_factor_parallel(3.0, 1.5, HEIGHT),
                  TOLERANCE);
}

static void upright_rectangle_gives_its_form_factor(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    add_plane(&writer, 0.0f);
    const int material = gltf_emitter(&writer, 0.0, RADIANCE, false);
    gltf_quad(&writer, material,
              (const float[]){1.2f, 0, 0, 1.2f, 0, 2, 1.2f, 2.5f, 2, 1.2f, 2.5f, 0});
    assert_agrees("E", see(&writer), RADIANCE * PI * form_factor_upright(2.5, 2.0, 1.2), TOLERANCE);
}

// Irradiance of the level plane at the origin by a polygon of radiance 1 above it (Lambert's
// formula): half the sum over its edges of the angle that each subtends times the level component
// of the edge's unit normal.
static double polygon_irradiance(const float *corners, int count)
{
    double sum = 0.0;
    for (int i = 0; i < count; i++) {
        const float *a = corners + 3 * i;
        const float *b = corners + 3 * ((i + 1) % count);
        const double aa = sqrt((double)a[0] * a[0] + (double)a[1] * a[1] + (double)a[2] * a[2]);
        const double bb = sqrt((double)b[0] * b[0] + (double)b[1] * b[1] + (double)b[2] * b[2]);
        const double ab = ((double)a[0] * b[0] + (double)a[1] * b[1] + (double)a[2] * b[2]);
        const double x = (double)a[1] * b[2] - (double)a[2] * b[1];
        const double y = (double)a[2] * b[0] - (double)a[0] * b[2];
        const double z = (double)a[0] * b[1] - (double)a[1] * b[0];
        sum += acos(ab / (aa * bb)) * y / sqrt(x * x + y * y + z * z);
    }
    return 0.5 * fabs(sum);
}

// Seen from the origin, these run clockwise, so their fronts look away from it.
static const float tilted[] = {-0.5f, 1.0f, -1.0f, 0.2f, 2.2f, 1.1f, 1.5f, 0.4f, 0.3f};

static struct estimate see_triangle(bool flipped, bool double_sided)
{
    struct gltf_writer writer = {0};
    float corners[9];
    for (int i = 0; i < 3; i++)
        memcpy(corners + 3 * i, tilted + 3 * (flipped ? 2 - i : i), 3 * sizeof(float));
    add_plane(&writer, 0.0f);
    gltf_triangle(&writer, gltf_emitter(&writer, 0.0, RADIANCE, double_sided), corners);
    return see(&writer);
}

static void emissive_triangle_gives_lamberts_formula(void **state)
{
    (void)state;
    skip_without_device();
    const double exact = RADIANCE * polygon_irradiance(tilted, 3);
    assert_agrees("front", see_triangle(true, false), exact, TOLERANCE);
}

static void surfaces_emit_in_front_and_behind_only_if_double_sided(void **state)
{
    (void)state;
    skip_without_device();
    const double exact = RADIANCE * polygon_irradiance(tilted, 3);
    assert_true(see_triangle(false, false).mean == 0.0);
    assert_agrees("behind", see_triangle(false, true), exact, TOLERANCE);
    assert_agrees("in front", see_triangle(true, true), exact, TOLERANCE);
}

// ---- Cameras and depth

// A lamp over a plane, with one camera that looks down at the plane and one up at the lamp.
static struct lk_scene *make_lamp_scene(void)
{
    struct gltf_writer writer = {0};
    add_plane(&writer, 0.25f);
    gltf_camera(&writer, "up", (const float[]){0.1f, 0.5f, 0.1f},
                (const float[]){0.0f, HEIGHT, 0.0f}, 0.2);
    gltf_floor(&writer, gltf_emitter(&writer, 0.5, RADIANCE, false), HEIGHT, 1.0f, false);
    return gltf_load(&writer);
}

static void depth_one_is_emission_and_direct_light(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_lamp_scene();
    struct lk_settings settings = test_settings(16, 16, 64);
    const double direct = RADIANCE * 4.0 * ALBEDO; // times the form factors of four quarters
    const double factors[] = {
        form_factor_parallel(1.25, 1.0, HEIGHT), form_factor_parallel(1.25, 1.0, HEIGHT),
        form_factor_parallel(0.75, 1.0, HEIGHT), form_factor_parallel(0.75, 1.0, HEIGHT)};
    double share = 0.0;
    for (int i = 0; i < 4; i++)
        share += factors[i] / 4.0;

    settings.depth = 1;
    assert_agrees("plane", estimate_point(scene, &settings), direct * share, TOLERANCE);
    settings.camera = "up";
    assert_close("lamp", render_mean(scene, &settings), RADIANCE);

    // The lamp's own reflection takes a second hit.
    settings.depth = 2;
    const double lit = render_mean(scene, &settings);
    assert_true(lit > RADIANCE * 1.01);
    lk_scene_free(scene);
}

static void direct_quantity_is_depth_one(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_lamp_scene();
    struct lk_settings settings = test_settings(8, 8, 4);
    settings.depth = 1;
    struct lk_image *shallow = render(scene, &settings);
    settings.depth = 5;
    settings.quantity = LK_DIRECT;
    struct lk_image *direct = render(scene, &settings);
    assert_true(is_same_image(shallow, direct));
    lk_image_free(direct);
    lk_image_free(shallow);
    lk_scene_free(scene);
}

// An unlit rectangle off the middle of what the camera sees: x grows to the right, y upwards.
static void orthographic_camera_sees_its_magnification(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    const int unlit = gltf_material(&writer, "{\"extensions\":{\"KHR_materials_unlit\":{}}}");
    gltf_quad(&writer, unlit, (const float[]){1, 1, 0, 2, 1, 0, 2, 3, 0, 1, 3, 0});
    gltf_camera_flat(&writer, "front", (const float[]){0, 0, 5}, (const float[]){0, 0, 0}, 4.0);
    struct lk_scene *scene = gltf_load(&writer);
    struct lk_settings settings = test_settings(8, 8, 1);
    struct lk_image *image = render(scene, &settings);
    uint32_t width, height;
    const float *pixels = lk_image_pixels(image, &width, &height);
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const bool inside =
                x == 5 && y >= 1 && y < 3; // one metre a pixel, (0, 0) in the middle
            assert_true(pixels[3 * (y * width + x)] == (inside ? 1.0f : 0.0f));
        }
    lk_image_free(image);
    lk_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(point_light_gives_intensity_cos_over_squared_distance),
        cmocka_unit_test(range_windows_a_point_light_and_ends_it),
        cmocka_unit_test(spot_falls_off_between_its_cones),
        cmocka_unit_test(spot_defaults_to_an_eighth_of_a_turn),
        cmocka_unit_test(directional_light_gives_its_lux_times_the_cosine),
        cmocka_unit_test(light_from_behind_the_plane_does_not_arrive),
        cmocka_unit_test(rectangle_overhead_gives_its_form_factor),
        cmocka_unit_test(upright_rectangle_gives_its_form_factor),
        cmocka_unit_test(emissive_triangle_gives_lamberts_formula),
        cmocka_unit_test(surfaces_emit_in_front_and_behind_only_if_double_sided),
        cmocka_unit_test(depth_one_is_emission_and_direct_light),
        cmocka_unit_test(direct_quantity_is_depth_one),
        cmocka_unit_test(orthographic_camera_sees_its_magnification),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
