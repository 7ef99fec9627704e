// The environment's distribution: densities integrate to one, drawing follows them, and wherever
// there is light the density is not 0.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "prep/environment.h"
#include "prep/sky.h"
#include "prep_support.h"
#include "scene/image_io.h"

#define EPSILON 1e-4 // relative: densities are floats

// Writes an image, loads it as an environment, and removes it.
static enum status load(struct environment *out, const float *rgb, uint32_t width, uint32_t height,
                        float strength)
{
    char path[] = "/tmp/lightkiln_XXXXXX.exr";
    const int file = mkstemps(path, 4);
    assert_true(file >= 0);
    close(file);
    assert_int_equal(image_write_rgb(path, rgb, width, height, NULL, 0), STATUS_OK);
    const struct environment_request request = {.path = path, .strength = strength};
    const enum status status = environment_build(out, &request);
    unlink(path);
    return status;
}

// A random image with a bright spot, black rows, and numbers far apart.
static float *make_image(uint32_t width, uint32_t height, uint64_t seed)
{
    float *rgb = calloc((size_t)width * height, 3 * sizeof(*rgb));
    for (uint32_t i = 0; i < width * height; i++)
        for (int k = 0; k < 3; k++)
            rgb[3 * i + k] = i / width % 4 == 3 ? 0.0f : (float)pow(random_unit(&seed), 8.0);
    rgb[3 * (height / 3 * width + width / 2)] = 5000.0f;
    return rgb;
}

static double texel_angle(const struct environment *e, uint32_t row)
{
    const double step = M_PI / e->map.height;
    return 2.0 * M_PI / e->map.width * (cos(row * step) - cos((row + 1) * step));
}

// The probability with which the alias table comes to each texel, [texels].
static double *find_probabilities(const struct environment *e)
{
    const uint32_t count = e->map.width * e->map.height;
    double *p = calloc(count, sizeof(*p));
    for (uint32_t i = 0; i < count; i++) {
        assert_in_range(e->alias[i].other, 0, count - 1);
        p[i] += e->alias[i].keep / (double)count;
        p[e->alias[i].other] += (1.0 - e->alias[i].keep) / (double)count;
    }
    return p;
}

static void check_distribution(const struct environment *e)
{
    const uint32_t width = e->map.width;
    const uint32_t count = width * e->map.height;
    double *p = find_probabilities(e);
    double integral = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        const double share = e->texels[i].w * texel_angle(e, i / width);
        integral += share;
        assert_true(fabs(p[i] - share) <= EPSILON * share + 1e-7 / count);
        if (e->texels[i].w == 0.0f)
            assert_true(p[i] == 0.0);
    }
    assert_true(fabs(integral - 1.0) < EPSILON);
    free(p);
}

static void densities_integrate_to_one_and_are_what_is_drawn(void **state)
{
    (void)state;
    const uint32_t sizes[][2] = {{1, 1}, {2, 1}, {1, 3}, {5, 4}, {64, 32}, {333, 77}};
    for (int i = 0; i < 6; i++) {
        struct environment e;
        float *rgb = make_image(sizes[i][0], sizes[i][1], (uint64_t)i + 1);
        assert_int_equal(load(&e, rgb, sizes[i][0], sizes[i][1], 1.0f), STATUS_OK);
        check_distribution(&e);
        environment_free(&e);
        free(rgb);
    }
}

// What bilinear filtering lets into a texel comes from its neighbours, too.
static void light_is_drawn_wherever_the_filter_carries_it(void **state)
{
    (void)state;
    const uint32_t width = 16;
    const uint32_t height = 8;
    float rgb[16 * 8 * 3] = {0};
    rgb[3 * (3 * width)] = 1.0f; // at the seam
    rgb[3 * (6 * width + 7) + 2] = 1.0f;
    struct environment e;
    assert_int_equal(load(&e, rgb, width, height, 1.0f), STATUS_OK);
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            const uint32_t from_seam = x < width - x ? x : width - x;
            const bool lit =
                (from_seam <= 1 && y >= 2 && y <= 4) || (x >= 6 && x <= 8 && y >= 5 && y <= 7);
            assert_true((e.texels[y * width + x].w > 0.0f) == lit);
        }
    }
    environment_free(&e);
}

static void one_radiance_all_around_is_drawn_evenly(void **state)
{
    (void)state;
    float rgb[12 * 7 * 3];
    for (int i = 0; i < 12 * 7 * 3; i++)
        rgb[i] = 2.5f;
    struct environment e;
    assert_int_equal(load(&e, rgb, 12, 7, 4.0f), STATUS_OK);
    for (uint32_t i = 0; i < 12 * 7; i++) {
        assert_true(e.texels[i].x == 10.0f);
        assert_true(fabs(e.texels[i].w * 4.0 * M_PI - 1.0) < EPSILON);
    }
    environment_free(&e);

    const struct environment_request request = {.background = {1.0f, 2.0f, 3.0f}};
    assert_int_equal(environment_build(&e, &request), STATUS_OK);
    assert_int_equal(e.map.width * e.map.height, 1);
    assert_true(e.texels[0].y == 2.0f);
    assert_true(fabs(e.texels[0].w * 4.0 * M_PI - 1.0) < EPSILON);
    environment_free(&e);
}

static void without_light_there_is_no_environment(void **state)
{
    (void)state;
    const float black[2 * 2 * 3] = {0};
    struct environment e;
    assert_int_equal(load(&e, black, 2, 2, 1.0f), STATUS_OK);
    assert_int_equal(e.map.width, 0);
    assert_null(e.texels);
    const struct environment_request nothing = {.strength = 1.0f};
    assert_int_equal(environment_build(&e, &nothing), STATUS_OK);
    assert_int_equal(e.map.width, 0);
    assert_int_equal(environment_size(&e), 0);
}

static void numbers_that_are_not_finite_are_refused(void **state)
{
    (void)state;
    float rgb[2 * 2 * 3] = {0};
    struct environment e;
    rgb[7] = INFINITY;
    assert_int_equal(load(&e, rgb, 2, 2, 1.0f), STATUS_FORMAT);
    assert_non_null(strstr(status_message(), ".exr"));
    assert_non_null(strstr(status_message(), "0, 1"));
    rgb[7] = -1.0f; // taken for black
    rgb[0] = 1.0f;
    assert_int_equal(load(&e, rgb, 2, 2, 1.0f), STATUS_OK);
    assert_true(e.texels[2].y == 0.0f);
    environment_free(&e);
    const struct environment_request missing = {.path = "/nowhere/sky.hdr", .strength = 1.0f};
    assert_int_equal(environment_build(&e, &missing), STATUS_IO);
    assert_non_null(strstr(status_message(), "/nowhere/sky.hdr"));
}

// ---- The sky

static struct environment make_sky(float azimuth, float elevation, float turbidity)
{
    const struct environment_request request = {.strength = 1.0f,
                                                .sky_azimuth_deg = azimuth,
                                                .sky_elevation_deg = elevation,
                                                .sky_turbidity = turbidity};
    struct environment e;
    assert_int_equal(environment_build(&e, &request), STATUS_OK);
    assert_true(e.has_sun);
    return e;
}

static void skies_glow_about_their_sun(void **state)
{
    (void)state;
    const float azimuths[] = {0.0f, 90.0f, 200.0f, -30.0f};
    for (int i = 0; i < 4; i++) {
        const float elevation = 20.0f + 15.0f * (float)i;
        struct environment e = make_sky(azimuths[i], elevation, 4.0f);
        check_distribution(&e);

        // The brightest texel is where the sun is.
        uint32_t brightest = 0;
        for (uint32_t k = 0; k < SKY_WIDTH * SKY_HEIGHT; k++) {
            assert_true(isfinite(e.texels[k].x) && e.texels[k].x >= 0.0f);
            if (e.texels[k].y > e.texels[brightest].y)
                brightest = k;
        }
        const double turn = 2.0 * M_PI * ((brightest % SKY_WIDTH + 0.5) / SKY_WIDTH - 0.5);
        const double angle = M_PI * (brightest / SKY_WIDTH + 0.5) / SKY_HEIGHT;
        const double towards[3] = {sin(angle) * sin(turn), cos(angle), -sin(angle) * cos(turn)};
        const float4 dir = e.sun.dir;
        assert_true(-dir.x * towards[0] - dir.y * towards[1] - dir.z * towards[2] > cos(0.02));
        assert_true(fabs(-dir.y - sin(elevation * M_PI / 180.0)) < 1e-6);
        environment_free(&e);
    }
}

static double luminance(float4 v)
{
    return 0.2126 * v.x + 0.7152 * v.y + 0.0722 * v.z;
}

// The zenith luminance is Preetham's own formula; at noon sky and sun give about 100,000 lux, dusk
// redder than noon.
static void daylight_is_as_bright_as_on_earth(void **state)
{
    (void)state;
    struct environment noon = make_sky(0.0f, 60.0f, 3.0f);
    struct environment dusk = make_sky(0.0f, 5.0f, 3.0f);
    const double chi = (4.0 / 9.0 - 3.0 / 120.0) * (M_PI - M_PI / 3.0);
    const double zenith = 1000.0 * ((4.0453 * 3.0 - 4.9710) * tan(chi) - 0.2155 * 3.0 + 2.4192);
    assert_true(fabs(luminance(noon.texels[0]) - zenith) < 0.01 * zenith);
    double sky_lux = 0.0;
    for (uint32_t y = 0; y < SKY_HEIGHT / 2; y++)
        for (uint32_t x = 0; x < SKY_WIDTH; x++)
            sky_lux += luminance(noon.texels[y * SKY_WIDTH + x]) * texel_angle(&noon, y) *
                       cos(M_PI * (y + 0.5) / SKY_HEIGHT);
    const double sun_lux = luminance(noon.sun.color) * sin(M_PI / 3.0);
    assert_true(sky_lux > 10000.0 && sky_lux < 40000.0);
    assert_true(sun_lux > 60000.0 && sun_lux < 110000.0);
    assert_true(luminance(dusk.sun.color) < 0.6 * luminance(noon.sun.color));
    assert_true(dusk.sun.color.x / dusk.sun.color.z > noon.sun.color.x / noon.sun.color.z);
    environment_free(&dusk);
    environment_free(&noon);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(densities_integrate_to_one_and_are_what_is_drawn),
        cmocka_unit_test(light_is_drawn_wherever_the_filter_carries_it),
        cmocka_unit_test(one_radiance_all_around_is_drawn_evenly),
        cmocka_unit_test(without_light_there_is_no_environment),
        cmocka_unit_test(numbers_that_are_not_finite_are_refused),
        cmocka_unit_test(skies_glow_about_their_sun),
        cmocka_unit_test(daylight_is_as_bright_as_on_earth),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
