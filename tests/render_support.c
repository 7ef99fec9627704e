#include "render_support.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

// Four standard errors: of normal values one in 16,000 lies farther out, of 15 degrees of freedom
// one in 900.
#define ERRORS_ALLOWED 4.0

#define SEEDS_MAX 64

void skip_without_device(void)
{
    struct lk_device_info info;
    if (lk_device_info(&info, 0) == LK_OK)
        return;
    print_message("note: skipped, %s\n", lk_error());
    skip();
}

static bool is_set(const char *variable, const char *value)
{
    const char *set = getenv(variable);
    return set != NULL && strcmp(set, value) == 0;
}

struct lk_settings test_settings(uint32_t width, uint32_t height, uint32_t spp)
{
    struct lk_settings settings;
    lk_settings_init(&settings);
    settings.width = width;
    settings.height = height;
    settings.spp = spp;
    settings.device = getenv("LIGHTKILN_TEST_DEVICE");
    if (is_set("LIGHTKILN_TEST_TRACE", "simple"))
        settings.trace = LK_TRACE_SIMPLE;
    if (is_set("LIGHTKILN_TEST_TRACE", "persistent"))
        settings.trace = LK_TRACE_PERSISTENT;
    if (is_set("LIGHTKILN_TEST_BVH", "binary"))
        settings.bvh = LK_BVH_BINARY;
    if (is_set("LIGHTKILN_TEST_BVH", "wide"))
        settings.bvh = LK_BVH_WIDE;
    if (is_set("LIGHTKILN_TEST_BVH", "quad"))
        settings.bvh = LK_BVH_QUAD;
    if (is_set("LIGHTKILN_TEST_BVH", "compressed"))
        settings.bvh = LK_BVH_COMPRESSED;
    if (is_set("LIGHTKILN_TEST_BVH_BUILD", "thesis"))
        settings.bvh_build = LK_BVH_BUILD_THESIS;
    return settings;
}

struct lk_image *render(struct lk_scene *scene, const struct lk_settings *settings)
{
    struct lk_image *image = NULL;
    if (lk_render(&image, scene, settings, NULL) != LK_OK)
        fail_msg("%s", lk_error());
    return image;
}

double image_mean(const struct lk_image *image)
{
    uint32_t width, height;
    const float *pixels = lk_image_pixels(image, &width, &height);
    const size_t count = (size_t)width * height * 3;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++)
        sum += pixels[i];
    return sum / (double)count;
}

double render_mean(struct lk_scene *scene, const struct lk_settings *settings)
{
    struct lk_image *image = render(scene, settings);
    const double mean = image_mean(image);
    lk_image_free(image);
    return mean;
}

struct rgb render_rgb(struct lk_scene *scene, const struct lk_settings *settings)
{
    struct lk_image *image = render(scene, settings);
    uint32_t width, height;
    const float *pixels = lk_image_pixels(image, &width, &height);
    const size_t count = (size_t)width * height;
    struct rgb mean = {{0.0, 0.0, 0.0}};
    for (size_t i = 0; i < 3 * count; i++)
        mean.v[i % 3] += pixels[i] / (double)count;
    lk_image_free(image);
    return mean;
}

struct estimate estimate_values(const double *values, uint32_t count)
{
    double mean = 0.0;
    double squares = 0.0;
    for (uint32_t i = 0; i < count; i++)
        mean += values[i] / count;
    for (uint32_t i = 0; i < count; i++)
        squares += (values[i] - mean) * (values[i] - mean);
    return (struct estimate){mean, sqrt(squares / (count - 1) / count)};
}

struct estimate estimate_point(struct lk_scene *scene, const struct lk_settings *settings)
{
    struct lk_image *image = render(scene, settings);
    uint32_t width, height;
    const float *pixels = lk_image_pixels(image, &width, &height);
    const uint32_t count = width * height;
    double *values = malloc(count * sizeof(*values));
    assert_non_null(values);
    for (uint32_t i = 0; i < count; i++)
        values[i] = ((double)pixels[3 * i] + pixels[3 * i + 1] + pixels[3 * i + 2]) / 3.0;
    const struct estimate estimate = estimate_values(values, count);
    free(values);
    lk_image_free(image);
    return estimate;
}

struct estimate estimate_image(struct lk_scene *scene, const struct lk_settings *settings,
                               uint32_t count)
{
    double values[SEEDS_MAX];
    struct lk_settings seeded = *settings;
    assert_in_range(count, 2, SEEDS_MAX);
    for (uint32_t i = 0; i < count; i++) {
        seeded.seed = i + 1;
        values[i] = render_mean(scene, &seeded);
    }
    return estimate_values(values, count);
}

bool is_same_image(const struct lk_image *a, const struct lk_image *b)
{
    uint32_t a_width, a_height, b_width, b_height;
    const float *a_pixels = lk_image_pixels(a, &a_width, &a_height);
    const float *b_pixels = lk_image_pixels(b, &b_width, &b_height);
    return a_width == b_width && a_height == b_height &&
           memcmp(a_pixels, b_pixels, (size_t)a_width * a_height * 3 * sizeof(float)) == 0;
}

void assert_agrees(const char *what, struct estimate estimate, double exact, double relative)
{
    const double allowed = ERRORS_ALLOWED * estimate.error + relative * fabs(exact);
    if (!(fabs(estimate.mean - exact) <= allowed))
        fail_msg("%s: %.9g, not %.9g +- %.3g (standard error %.3g)", what, estimate.mean, exact,
                 allowed, estimate.error);
}

void assert_same_mean(const char *what, struct estimate a, struct estimate b)
{
    const double error = sqrt(a.error * a.error + b.error * b.error);
    if (!(fabs(a.mean - b.mean) <= ERRORS_ALLOWED * error))
        fail_msg("%s: %.9g and %.9g differ by more than four standard errors of %.3g", what, a.mean,
                 b.mean, error);
}
