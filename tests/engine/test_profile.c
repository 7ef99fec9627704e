// Laws of what a profile tells.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <string.h>

#include "gltf_writer.h"
#include "render_support.h"

#define SIDE 16u
#define SPP  8u

static struct lk_scene *scene; // of the group

// A floor that fills the view, a lamp and a sun above it.
static int make_scene(void **state)
{
    (void)state;
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 20.0f, true);
    gltf_camera_flat(&writer, "above", (const float[]){0, 5, 0.01f}, (const float[]){0, 0, 0}, 1.0);
    gltf_light(&writer, (const float[]){0, 2, 0}, (const float[]){0, 0, 0.01f},
               "{\"type\":\"point\"}");
    gltf_light(&writer, (const float[]){0, 2, 0}, (const float[]){0, 0, 0.01f},
               "{\"type\":\"directional\"}");
    scene = gltf_load(&writer);
    return 0;
}

static int free_scene(void **state)
{
    (void)state;
    lk_scene_free(scene);
    return 0;
}

static const struct lk_kernel_time *find(const struct lk_render_info *info, const char *name)
{
    for (uint32_t i = 0; i < info->kernel_count; i++)
        if (strcmp(info->kernels[i].name, name) == 0)
            return &info->kernels[i];
    fail_msg("there is no kernel %s", name);
    return NULL;
}

// Every path hits the floor, which sees both lights.
static void kernels_are_told_the_rays_they_traced(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(SIDE, SIDE, SPP);
    const uint64_t paths = (uint64_t)SIDE * SIDE * SPP;
    settings.depth = 1;
    settings.profile = true;
    for (uint32_t n = 1; n <= 4; n += 3) {
        settings.shadow_rays = n;
        struct lk_image *image = render(scene, &settings);
        const struct lk_render_info *info = lk_image_info(image);
        assert_int_equal(find(info, "trace")->rays, info->rays_camera + info->rays_indirect);
        assert_int_equal(find(info, "direct")->rays, paths * n);
        assert_int_equal(find(info, "directional")->rays, paths);
        assert_int_equal(info->rays_directional, paths);
        assert_int_equal(info->rays_shadow, paths * (n + 1));
        assert_int_equal(find(info, "raygen")->rays, 0);
        assert_true(find(info, "raygen")->bytes >= 64 * paths);
        lk_image_free(image);
    }
}

static void render_without_profile_times_no_kernel(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = test_settings(SIDE, SIDE, SPP);
    struct lk_image *image = render(scene, &settings);
    assert_int_equal(lk_image_info(image)->kernel_count, 0);
    lk_image_free(image);
}

// The programs that the kernels are of: a stage of several kernels names them stage_kernel.
static uint32_t count_programs(const struct lk_render_info *info)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < info->kernel_count; i++) {
        const char *name = info->kernels[i].name;
        const size_t length = strcspn(name, "_");
        bool is_first = true;
        for (uint32_t j = 0; j < i; j++)
            is_first = is_first && !(strcspn(info->kernels[j].name, "_") == length &&
                                     strncmp(info->kernels[j].name, name, length) == 0);
        count += is_first;
    }
    return count;
}

// All from source, each once, and none that is not used: with the form of tracing named that the
// device takes by itself, so that none is tried for the sake of choosing.
static void no_program_is_compiled_twice(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = test_settings(SIDE, SIDE, SPP);
    settings.depth = 2;
    settings.profile = true;
    settings.no_cache = true;
    struct lk_image *image = render(scene, &settings);
    const struct lk_device_share *share = lk_image_info(image)->devices;
    settings.trace = share->trace;
    settings.bvh = share->bvh;
    lk_image_free(image);
    image = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(image);
    assert_int_equal(info->kernels_from_source, count_programs(info));
    lk_image_free(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(no_program_is_compiled_twice),
        cmocka_unit_test(kernels_are_told_the_rays_they_traced),
        cmocka_unit_test(render_without_profile_times_no_kernel),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
