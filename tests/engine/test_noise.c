// Laws of renders that end at a noise.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "gltf_writer.h"
#include "render_support.h"

static struct lk_scene *scene; // of the group

// A room lit by a small lamp: even on the floor, noisy where the lamp's light comes by a mirror.
static int make_scene(void **state)
{
    (void)state;
    struct gltf_writer writer = {0};
    gltf_room(&writer, gltf_lambert(&writer, 0.5), (const float[]){-2, -1, -2},
              (const float[]){2, 2, 3});
    gltf_floor(&writer, gltf_emitter(&writer, 0.2, 30.0, false), 1.9f, 0.3f, false);
    const int mirror =
        gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"roughnessFactor\":0.05}}");
    gltf_triangle(&writer, mirror,
                  (const float[]){-1.9f, -0.9f, -1, -1, -0.9f, -1, -1.5f, 0.5f, -1});
    gltf_camera(&writer, "front", (const float[]){0.1f, 0.3f, 2.9f}, (const float[]){0, -0.2f, 0},
                1.1);
    scene = gltf_load(&writer);
    return 0;
}

static int free_scene(void **state)
{
    (void)state;
    lk_scene_free(scene);
    return 0;
}

// No limit but the noise.
static struct lk_settings noise_settings(uint32_t width, uint32_t height, float noise)
{
    struct lk_settings settings = test_settings(width, height, 0);
    settings.noise = noise;
    return settings;
}

static void the_noise_asked_for_is_reached(void **state)
{
    (void)state;
    skip_without_device();
    double last = 0.0; // samples
    for (float noise = 0.1f; noise > 0.04f; noise *= 0.5f) {
        const struct lk_settings settings = noise_settings(64, 64, noise);
        struct lk_image *image = render(scene, &settings);
        const struct lk_render_info *info = lk_image_info(image);
        assert_true(info->noise > 0.0 && info->noise <= noise);
        assert_true(info->spp > 1.5 * last);
        assert_true(info->paths == info->rays_camera);
        last = info->spp;
        lk_image_free(image);
    }
}

static void equal_settings_give_equal_bits(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = noise_settings(75, 53, 0.3f);
    struct lk_image *first = render(scene, &settings);
    settings.queue = 3000;
    struct lk_image *second = render(scene, &settings);
    assert_true(is_same_image(first, second));
    assert_true(lk_image_info(first)->noise == lk_image_info(second)->noise);
    lk_image_free(second);
    lk_image_free(first);
}

// Where no part can be good enough, all parts have the samples that they may have.
static void samples_end_it_first(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(40, 30, 24);
    struct lk_image *uniform = render(scene, &settings);
    settings.noise = 1e-6f;
    struct lk_image *image = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(image);
    assert_true(info->spp == 24.0 && info->noise > settings.noise);
    assert_true(is_same_image(uniform, image)); // the same samples, added in the same order
    assert_true(lk_image_info(uniform)->noise < 0.0);
    lk_image_free(image);
    lk_image_free(uniform);
}

static void time_ends_it_first(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = noise_settings(40, 30, 1e-6f);
    settings.time_s = 0.3;
    struct lk_image *image = render(scene, &settings);
    assert_true(lk_image_info(image)->spp >= 1.0 && lk_image_info(image)->time_s.render >= 0.3);
    lk_image_free(image);
}

static void a_noise_that_is_none_is_refused(void **state)
{
    (void)state;
    const float bad[] = {-0.1f, NAN, INFINITY};
    for (int i = 0; i < 3; i++) {
        struct lk_image *image = NULL;
        const struct lk_settings settings = noise_settings(8, 8, bad[i]);
        assert_int_equal(lk_render(&image, scene, &settings, NULL), LK_USAGE);
        assert_non_null(strstr(lk_error(), "noise"));
    }
}

static void mean_is_that_of_uniform_samples(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings adaptive = noise_settings(32, 32, 0.5f);
    const struct lk_settings uniform = test_settings(32, 32, 64);
    assert_same_mean("noise and samples", estimate_image(scene, &adaptive, 24),
                     estimate_image(scene, &uniform, 24));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_noise_asked_for_is_reached),
        cmocka_unit_test(equal_settings_give_equal_bits),
        cmocka_unit_test(samples_end_it_first),
        cmocka_unit_test(time_ends_it_first),
        cmocka_unit_test(a_noise_that_is_none_is_refused),
        cmocka_unit_test(mean_is_that_of_uniform_samples),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
