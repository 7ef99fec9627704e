// Several devices make the picture of one. PoCL is told to show its CPU twice.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "gltf_writer.h"
#include "render_support.h"

static struct lk_scene *scene; // of the group: a lit room, and a wall of radiance 1 that fills the
                               // view of camera "wall"
static char pair[64];          // two devices that compute alike; "" if there are none
static char one[32];           // the first of them

// Finds two devices of one name.
static void find_pair(void)
{
    struct lk_device_info a, b;
    for (size_t i = 0; pair[0] == '\0' && lk_device_info(&a, i) == LK_OK; i++)
        for (size_t j = i + 1; pair[0] == '\0' && lk_device_info(&b, j) == LK_OK; j++)
            if (strcmp(a.name, b.name) == 0 && strcmp(a.driver, b.driver) == 0) {
                snprintf(one, sizeof(one), "%u:%u", a.platform_index, a.device_index);
                snprintf(pair, sizeof(pair), "%s,%u:%u", one, b.platform_index, b.device_index);
            }
}

static void skip_without_pair(void)
{
    if (pair[0] != '\0')
        return;
    print_message("note: skipped, there are no two devices of one kind\n");
    skip();
}

static int make_scene(void **state)
{
    (void)state;
    struct gltf_writer writer = {0};
    gltf_room(&writer, gltf_lambert(&writer, 0.7), (const float[]){-2, -1, -2},
              (const float[]){2, 2, 3});
    gltf_floor(&writer, gltf_emitter(&writer, 0.2, 3.0, false), 1.9f, 0.6f, false);
    gltf_triangle(&writer, gltf_lambert(&writer, 0.4),
                  (const float[]){-1, 0, 1, -0.5f, 0.4f, 1, -1, 0.6f, 1.2f});
    gltf_light(&writer, (const float[]){1, 1, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":2,\"range\":3}");
    gltf_light(&writer, (const float[]){1, 2, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"directional\",\"intensity\":1}");
    gltf_camera(&writer, "front", (const float[]){0.1f, 0.3f, 2.9f}, (const float[]){0, 0.2f, 0},
                1.1);
    gltf_quad(&writer, gltf_emitter(&writer, 0.0, 1.0, true),
              (const float[]){-9, -9, -20, 9, -9, -20, 9, 9, -20, -9, 9, -20});
    gltf_camera_flat(&writer, "wall", (const float[]){0, 0, -19}, (const float[]){0, 0, -20}, 1.0);
    scene = gltf_load(&writer);
    find_pair();
    return 0;
}

static int free_scene(void **state)
{
    (void)state;
    lk_scene_free(scene);
    return 0;
}

// Renders on one device and on two: the pictures are the same, and so is the noise that ends them.
static void check_pair(const struct lk_settings *settings)
{
    struct lk_settings on = *settings;
    on.device = one;
    struct lk_image *alone = render(scene, &on);
    on.device = pair;
    struct lk_image *shared = render(scene, &on);
    assert_true(is_same_image(alone, shared));
    if (settings->noise > 0.0f)
        assert_true(lk_image_info(alone)->noise == lk_image_info(shared)->noise);
    lk_image_free(shared);
    lk_image_free(alone);
}

static void several_devices_give_the_bits_of_one(void **state)
{
    (void)state;
    skip_without_pair();
    const uint32_t spps[] = {1, 2, 37, 64};
    for (size_t i = 0; i < sizeof(spps) / sizeof(spps[0]); i++) {
        const struct lk_settings settings = test_settings(75, 53, spps[i]);
        check_pair(&settings);
    }
}

static void a_picture_smaller_than_its_devices_is_whole(void **state)
{
    (void)state;
    skip_without_pair();
    const struct lk_settings settings = test_settings(1, 1, 100);
    check_pair(&settings);
}

static void several_devices_stop_at_a_noise_as_one_does(void **state)
{
    (void)state;
    skip_without_pair();
    struct lk_settings settings = test_settings(75, 53, 0);
    settings.noise = 0.3f;
    check_pair(&settings);
}

static void every_path_is_told_of_once(void **state)
{
    (void)state;
    skip_without_pair();
    struct lk_settings settings = test_settings(64, 48, 50);
    settings.device = pair;
    settings.profile = true;
    struct lk_image *image = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(image);
    assert_int_equal(info->device_count, 2);
    assert_string_equal(info->device.name, info->devices[0].info.name);
    assert_int_equal(info->paths, 64 * 48 * 50);
    assert_int_equal(info->rays_camera, info->paths);
    assert_int_equal(info->devices[0].paths + info->devices[1].paths, info->paths);
    assert_true(info->spp == 50.0);
    for (int i = 0; i < 2; i++) {
        const struct lk_device_share *share = &info->devices[i];
        assert_true(share->queue > 0 && share->memory > 0);
        assert_true(share->trace != LK_TRACE_AUTO && share->bvh != LK_BVH_AUTO);
        assert_true((share->paths > 0) == (share->busy_s > 0.0));
    }

    // One table for both: each launch of raygen starts some paths.
    uint32_t names = 0;
    for (uint32_t k = 0; k < info->kernel_count; k++)
        names += strcmp(info->kernels[k].name, "raygen") == 0;
    assert_int_equal(names, 1);
    lk_image_free(image);
}

static void time_ends_a_shared_render(void **state)
{
    (void)state;
    skip_without_pair();
    struct lk_settings settings = test_settings(40, 30, 0);
    settings.device = pair;
    settings.time_s = 0.3;
    settings.camera = "wall";
    struct lk_image *image = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(image);
    assert_true(info->spp >= 1.0 && info->time_s.render >= 0.3);
    uint32_t width, height;
    const float *pixels = lk_image_pixels(image, &width, &height);
    for (uint32_t i = 0; i < width * height * 3; i++)
        assert_true(pixels[i] == 1.0f); // each of a pixel's samples was, and it had some
    lk_image_free(image);
}

static bool cancel_rendering(void *user, const struct lk_progress *progress)
{
    (void)user;
    assert_true(progress->fraction >= 0.0 && progress->fraction <= 1.0);
    return strcmp(progress->stage, "rendering") != 0;
}

static void cancelled_shared_render_keeps_what_was_finished(void **state)
{
    (void)state;
    skip_without_pair();
    const struct lk_progress_hook hook = {cancel_rendering, NULL};
    struct lk_settings settings = test_settings(16, 16, 1u << 24);
    struct lk_image *image = NULL;
    settings.device = pair;
    settings.camera = "wall";
    assert_int_equal(lk_render(&image, scene, &settings, &hook), LK_CANCELLED);
    assert_non_null(strstr(lk_error(), "rendering"));
    assert_non_null(image);
    assert_true(lk_image_info(image)->spp >= 1.0 && lk_image_info(image)->spp < settings.spp);
    assert_true(image_mean(image) == 1.0);
    lk_image_free(image);
}

static void assert_refused(const char *devices, enum lk_status expected, const char *word)
{
    struct lk_settings settings = test_settings(8, 8, 1);
    struct lk_image *image = NULL;
    settings.device = devices;
    assert_int_equal(lk_render(&image, scene, &settings, NULL), expected);
    if (strstr(lk_error(), word) == NULL)
        fail_msg("%s: \"%s\" does not say %s", devices, lk_error(), word);
    assert_null(image);
}

static void a_device_is_taken_once(void **state)
{
    (void)state;
    skip_without_pair();
    char list[128];
    snprintf(list, sizeof(list), "%s,%s", one, one);
    assert_refused(list, LK_NO_DEVICE, "no further device matches");
    snprintf(list, sizeof(list), "%s,no such device", one);
    assert_refused(list, LK_NO_DEVICE, "no such device");
    snprintf(list, sizeof(list), "%s,", one);
    assert_refused(list, LK_USAGE, "without a name");
    assert_refused(",", LK_USAGE, "without a name");
}

static void all_takes_every_device(void **state)
{
    (void)state;
    skip_without_pair();
    struct lk_device_info info;
    uint32_t usable = 0;
    for (size_t i = 0; lk_device_info(&info, i) == LK_OK; i++)
        usable += info.usable;
    struct lk_settings settings = test_settings(16, 16, 4);
    static const char *const lists[] = {"all", "best,all"};
    for (int i = 0; i < 2; i++) {
        settings.device = lists[i];
        struct lk_image *image = render(scene, &settings);
        assert_int_equal(lk_image_info(image)->device_count, usable);
        lk_image_free(image);
    }
}

static void rays_are_traced_on_one_device_alone(void **state)
{
    (void)state;
    skip_without_pair();
    struct lk_settings settings = test_settings(8, 8, 1);
    struct lk_tracer *tracer = NULL;
    settings.device = pair;
    assert_int_equal(lk_tracer_create(&tracer, scene, &settings), LK_USAGE);
    assert_null(tracer);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(several_devices_give_the_bits_of_one),
        cmocka_unit_test(a_picture_smaller_than_its_devices_is_whole),
        cmocka_unit_test(several_devices_stop_at_a_noise_as_one_does),
        cmocka_unit_test(every_path_is_told_of_once),
        cmocka_unit_test(time_ends_a_shared_render),
        cmocka_unit_test(cancelled_shared_render_keeps_what_was_finished),
        cmocka_unit_test(a_device_is_taken_once),
        cmocka_unit_test(all_takes_every_device),
        cmocka_unit_test(rays_are_traced_on_one_device_alone),
    };
    setenv("POCL_DEVICES", "pthread pthread", 0); // read when PoCL starts
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
