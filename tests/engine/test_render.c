// lk_render() as a caller meets it: limits, cancelling, cameras, and what it refuses.

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

// An unlit white triangle that fills half of what the first camera sees and all of the second.
static int make_scene(void **state)
{
    (void)state;
    struct gltf_writer writer = {0};
    const int unlit = gltf_material(&writer, "{\"extensions\":{\"KHR_materials_unlit\":{}}}");
    gltf_triangle(&writer, unlit, (const float[]){-2, -2, 0, 2, -2, 0, -2, 2, 0});
    gltf_camera_flat(&writer, "half", (const float[]){0, 0, 1}, (const float[]){0, 0, 0}, 1.0);
    gltf_camera_flat(&writer, "full", (const float[]){-1, -1, 1}, (const float[]){-1, -1, 0}, 0.5);
    scene = gltf_load(&writer);
    return 0;
}

static int free_scene(void **state)
{
    (void)state;
    lk_scene_free(scene);
    return 0;
}

// The hypotenuse cuts pixels: each sample is 0 or 1, and which is told by what one more adds.
static void image_is_the_average_of_its_samples(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(33, 33, 4);
    struct lk_image *four = render(scene, &settings);
    settings.spp = 5;
    struct lk_image *five = render(scene, &settings);
    uint32_t width, height;
    const float *a = lk_image_pixels(four, &width, &height);
    const float *b = lk_image_pixels(five, &width, &height);
    int between = 0;
    for (uint32_t i = 0; i < 3 * width * height; i++) {
        const double last = 5.0 * b[i] - 4.0 * a[i];
        assert_true(fabs(last) < 1e-5 || fabs(last - 1.0) < 1e-5);
        between += b[i] > 0.0f && b[i] < 1.0f;
    }
    assert_true(between > 30);
    lk_image_free(five);
    lk_image_free(four);
}

static void cameras_are_found_by_name_and_index(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(16, 16, 4);
    assert_string_equal(lk_scene_camera(scene, 0), "half");
    assert_string_equal(lk_scene_camera(scene, 1), "full");
    assert_null(lk_scene_camera(scene, 2));
    const double first = render_mean(scene, &settings);
    settings.camera = "0";
    assert_true(render_mean(scene, &settings) == first && first < 0.6);
    settings.camera = "half";
    assert_true(render_mean(scene, &settings) == first);
    settings.camera = "1";
    assert_true(render_mean(scene, &settings) == 1.0);
    settings.camera = "full";
    assert_true(render_mean(scene, &settings) == 1.0);
}

// ---- Ends

// Cancels at a stage, if it is not NULL, and counts what it hears.
struct listener {
    const char *cancel_stage;
    int reports;
    bool in_order; // fractions within 0 .. 1, time never runs backwards
    double elapsed_s;
};

static bool listen(void *user, const struct lk_progress *progress)
{
    struct listener *listener = user;
    listener->reports++;
    listener->in_order = listener->in_order && progress->fraction >= 0.0 &&
                         progress->fraction <= 1.0 && progress->elapsed_s >= listener->elapsed_s;
    listener->elapsed_s = progress->elapsed_s;
    return listener->cancel_stage == NULL || strcmp(progress->stage, listener->cancel_stage) != 0;
}

static void cancelled_render_keeps_what_was_finished(void **state)
{
    (void)state;
    skip_without_device();
    struct listener listener = {.cancel_stage = "rendering", .in_order = true};
    const struct lk_progress_hook hook = {listen, &listener};
    struct lk_settings settings = test_settings(16, 16, 1u << 24);
    struct lk_image *image = NULL;
    settings.camera = "full";
    assert_int_equal(lk_render(&image, scene, &settings, &hook), LK_CANCELLED);
    assert_non_null(image);
    assert_non_null(strstr(lk_error(), "rendering"));
    assert_true(listener.in_order);

    // Every pixel has had samples by then, and each was 1.
    const struct lk_render_info *info = lk_image_info(image);
    assert_true(info->spp >= 1.0 && info->spp < settings.spp);
    assert_true(image_mean(image) == 1.0);
    lk_image_free(image);
}

static void render_cancelled_before_the_first_ray_gives_no_image(void **state)
{
    (void)state;
    skip_without_device();
    static const char *const stages[] = {"preparing", "building kernels"};
    for (int i = 0; i < 2; i++) {
        struct listener listener = {.cancel_stage = stages[i], .in_order = true};
        const struct lk_progress_hook hook = {listen, &listener};
        const struct lk_settings settings = test_settings(16, 16, 1);
        struct lk_image *image = NULL;
        assert_int_equal(lk_render(&image, scene, &settings, &hook), LK_CANCELLED);
        assert_null(image);
    }
}

static void progress_is_told_in_order(void **state)
{
    (void)state;
    skip_without_device();
    struct listener listener = {.in_order = true};
    const struct lk_progress_hook hook = {listen, &listener};
    const struct lk_settings settings = test_settings(64, 64, 16);
    struct lk_image *image = NULL;
    assert_int_equal(lk_render(&image, scene, &settings, &hook), LK_OK);
    assert_true(listener.in_order && listener.reports >= 3);
    lk_image_free(image);
}

static void time_limit_ends_a_render(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(16, 16, 0);
    settings.time_s = 0.3;
    settings.camera = "full";
    struct lk_image *image = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(image);
    assert_true(info->spp >= 1.0);
    assert_true(info->time_s.render >= settings.time_s);
    assert_true(info->time_s.render < settings.time_s + 5.0); // a batch or two on a busy machine
    assert_true(image_mean(image) == 1.0);
    lk_image_free(image);
}

static void samples_end_a_render_before_its_time(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(16, 16, 2);
    settings.time_s = 1000.0;
    struct lk_image *image = render(scene, &settings);
    assert_true(lk_image_info(image)->spp == 2.0);
    assert_true(lk_image_info(image)->paths == 16 * 16 * 2);
    assert_true(lk_image_info(image)->rays_camera == 16 * 16 * 2);
    lk_image_free(image);
}

// ---- Refusals

static void assert_refused(const struct lk_settings *settings, enum lk_status status,
                           const char *word)
{
    struct lk_image *image = NULL;
    const enum lk_status got = lk_render(&image, scene, settings, NULL);
    if (got != status)
        fail_msg("%s, not %s: %s", lk_status_name(got), lk_status_name(status), lk_error());
    assert_null(image);
    if (strstr(lk_error(), word) == NULL)
        fail_msg("no \"%s\" in \"%s\"", word, lk_error());
}

static void settings_out_of_range_are_refused(void **state)
{
    (void)state;
    const struct lk_settings good = test_settings(16, 16, 1);
    struct lk_settings bad[15];
    for (int i = 0; i < 15; i++)
        bad[i] = good;
    bad[0].depth = 0;
    bad[1].depth = 256;
    bad[2].shadow_rays = 0;
    bad[3].shadow_rays = 65;
    bad[4].leaf_size = 1;
    bad[5].leaf_size = 33;
    bad[6].split_threshold = -1.0f;
    bad[7].split_threshold = NAN;
    bad[8].spp = 0;
    bad[9].spp = (1u << 24) + 1;
    bad[10].time_s = -1.0;
    bad[11].time_s = NAN;
    bad[12].width = 16385;
    bad[13].height = 16385;
    bad[14].roulette_depth = 256;
    for (int i = 0; i < 15; i++) {
        assert_refused(&bad[i], LK_USAGE, "");
        assert_true(strlen(lk_error()) > 0);
    }
}

static void unknown_camera_is_refused_by_name(void **state)
{
    (void)state;
    struct lk_settings settings = test_settings(16, 16, 1);
    settings.camera = "nowhere";
    assert_refused(&settings, LK_USAGE, "nowhere");
    assert_refused(&settings, LK_USAGE, "full"); // the message lists those that there are
    settings.camera = "2";
    assert_refused(&settings, LK_USAGE, "2");
}

static void unknown_device_is_refused_by_name(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(16, 16, 1);
    settings.device = "abacus";
    assert_refused(&settings, LK_NO_DEVICE, "abacus");
    settings.device = "99:0";
    assert_refused(&settings, LK_NO_DEVICE, "99:0");
}

static void too_little_memory_names_its_users(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(1024, 1024, 4);
    settings.memory_limit = 1000;
    assert_refused(&settings, LK_NO_MEMORY, "rays");
    assert_refused(&settings, LK_NO_MEMORY, "film");
}

static unsigned warnings_of_a_render(const struct lk_settings *settings, struct lk_scene *of)
{
    const unsigned before = lk_warning_count();
    struct lk_image *image = render(of, settings);
    const unsigned given = lk_warning_count() - before;
    lk_image_free(image);
    return given;
}

// Only where nothing shines is there a warning.
static void black_picture_is_warned_of(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 20.0f, true);
    gltf_camera_flat(&writer, "above", (const float[]){0, 5, 0.01f}, (const float[]){0, 0, 0}, 1.0);
    struct lk_scene *dark = gltf_load(&writer);
    struct lk_settings settings = test_settings(8, 8, 1);
    assert_int_equal(warnings_of_a_render(&settings, scene), 0); // it is unlit
    assert_int_equal(warnings_of_a_render(&settings, dark), 1);
    for (int i = 0; i < 3; i++)
        settings.background[i] = 1.0f;
    assert_int_equal(warnings_of_a_render(&settings, dark), 0);
    lk_scene_free(dark);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(image_is_the_average_of_its_samples),
        cmocka_unit_test(cameras_are_found_by_name_and_index),
        cmocka_unit_test(cancelled_render_keeps_what_was_finished),
        cmocka_unit_test(render_cancelled_before_the_first_ray_gives_no_image),
        cmocka_unit_test(progress_is_told_in_order),
        cmocka_unit_test(black_picture_is_warned_of),
        cmocka_unit_test(time_limit_ends_a_render),
        cmocka_unit_test(samples_end_a_render_before_its_time),
        cmocka_unit_test(settings_out_of_range_are_refused),
        cmocka_unit_test(unknown_camera_is_refused_by_name),
        cmocka_unit_test(unknown_device_is_refused_by_name),
        cmocka_unit_test(too_little_memory_names_its_users),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
