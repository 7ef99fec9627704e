// One kernel for a bounce: it gives what its stages by themselves give.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "gltf_writer.h"
#include "render_support.h"
#include "choice.h"

// Of CPUs, stages shade eight hits side by side, which rounds otherwise: a path in thousands goes
// another way.
#define PIXEL_TOLERANCE 1e-3  // of the mean
#define PIXELS_ALLOWED  0.002 // share of those that differ by more

static struct lk_scene *scene;  // of the group
static struct lk_scene *glazed; // the same behind a coloured pane, which takes rays by chance

// A room with a lamp, a lamp that has no area, a mirror, and something that is cut out of a
// texture.
static struct lk_scene *make_room(bool has_pane)
{
    static const uint8_t texels[] = {255, 10, 0, 255, 20, 128, 60,  0,
                                     3,   40, 9, 255, 80, 200, 250, 255};
    struct gltf_writer writer = {0};
    const int texture = gltf_texture(&writer, texels, 2, 2);
    const int masked =
        gltf_material(&writer,
                      "{\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"roughnessFactor\":0.3,"
                      "\"metallicFactor\":0.5,\"baseColorTexture\":{\"index\":%d}}}",
                      texture);
    static const float positions[] = {-1, -1, 0.2f, 1, -1, 0, 1, 0.9f, 0, -1, 1, -0.1f};
    static const float texcoords[] = {0, 2, 2, 2, 2, 0, 0, 0};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    const struct gltf_mesh mesh = {.positions = positions,
                                   .texcoords = texcoords,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    gltf_node(&writer, "{\"mesh\":%d}", gltf_mesh(&writer, masked, &mesh));
    gltf_room(&writer, gltf_lambert(&writer, 0.7), (const float[]){-2, -1, -2},
              (const float[]){2, 2, 3});
    gltf_floor(&writer, gltf_emitter(&writer, 0.2, 3.0, false), 1.9f, 0.6f, false);
    const int mirror = gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"metallicFactor\":1,"
                                              "\"roughnessFactor\":0.1}}");
    gltf_triangle(&writer, mirror, (const float[]){-2, -0.5f, 1, -1, -0.5f, -1, -1.5f, 1, 0});
    if (has_pane)
        gltf_triangle(&writer,
                      gltf_material(&writer,
                                    "{\"doubleSided\":true,\"pbrMetallicRoughness\":{"
                                    "\"baseColorFactor\":[0.9,0.3,0.2,1],\"roughnessFactor\":0,"
                                    "\"metallicFactor\":0},\"extensions\":{"
                                    "\"KHR_materials_transmission\":{\"transmissionFactor\":1}}}"),
                      (const float[]){0.5f, -1, 1, 1.8f, -1, 1, 1, 1, 1});
    gltf_light(&writer, (const float[]){1, 1, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":2,\"range\":3}");
    gltf_camera(&writer, "front", (const float[]){0.1f, 0.3f, 2.9f}, (const float[]){0, 0.2f, 0},
                1.1);
    return gltf_load(&writer);
}

static int make_scenes(void **state)
{
    (void)state;
    scene = make_room(false);
    glazed = make_room(true);
    return 0;
}

static int free_scenes(void **state)
{
    (void)state;
    lk_scene_free(glazed);
    lk_scene_free(scene);
    return 0;
}

static int stop_fusing(void **state)
{
    (void)state;
    choice_always_fuses = false;
    return 0;
}

static struct lk_settings plain_settings(void)
{
    struct lk_settings settings = test_settings(75, 53, 4);
    settings.trace = LK_TRACE_SIMPLE;
    settings.bvh = LK_BVH_BINARY;
    return settings;
}

// Renders by one kernel or by stages. Where kernels are timed they are always stages.
static struct lk_image *render_by(const struct lk_settings *settings, bool fused)
{
    struct lk_settings chosen = *settings;
    chosen.profile = !fused;
    choice_always_fuses = fused;
    struct lk_image *image = render(scene, &chosen);
    assert_int_equal(lk_image_info(image)->devices[0].fused,
                     fused && settings->trace == LK_TRACE_SIMPLE);
    return image;
}

static void assert_alike(const char *what, const struct lk_image *a, const struct lk_image *b)
{
    uint32_t width, height;
    const float *x = lk_image_pixels(a, &width, &height);
    const float *y = lk_image_pixels(b, &width, &height);
    const size_t count = (size_t)width * height * 3;
    const double mean = image_mean(b);
    size_t others = 0;
    for (size_t i = 0; i < count; i++)
        others += !(fabs((double)x[i] - (double)y[i]) <= PIXEL_TOLERANCE * mean);
    print_message("%s: %zu of %zu values differ\n", what, others, count);
    assert_true(mean > 0.01);
    assert_true((double)others <= PIXELS_ALLOWED * (double)count);
    assert_true(fabs(image_mean(a) - mean) <= 0.01 * mean);
}

static void assert_fuses(const char *what, const struct lk_settings *settings)
{
    struct lk_image *fused = render_by(settings, true);
    struct lk_image *stages = render_by(settings, false);
    assert_alike(what, fused, stages);
    const struct lk_render_info *a = lk_image_info(fused);
    const struct lk_render_info *b = lk_image_info(stages);
    assert_int_equal(a->rays_camera, b->rays_camera);
    assert_true(fabs((double)a->rays_indirect - (double)b->rays_indirect) <=
                0.01 * (double)b->rays_indirect);
    assert_true(fabs((double)a->rays_shadow - (double)b->rays_shadow) <=
                0.01 * (double)b->rays_shadow);
    lk_image_free(stages);
    lk_image_free(fused);
}

// ---- laws

static void any_sampler_gives_the_picture_of_the_stages(void **state)
{
    (void)state;
    skip_without_device();
    static const struct {
        const char *name;
        enum lk_light_sampler lights;
        uint32_t shadow_rays;
    } cases[] = {{"uniform", LK_LIGHTS_UNIFORM, 1},
                 {"tree", LK_LIGHTS_TREE, 3},
                 {"all", LK_LIGHTS_ALL, 1},
                 {"importance", LK_LIGHTS_IMPORTANCE, 2}};
    struct lk_settings settings = plain_settings();
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        settings.light_sampler = cases[i].lights;
        settings.shadow_rays = cases[i].shadow_rays;
        assert_fuses(cases[i].name, &settings);
    }
}

static void any_quantity_and_depth_give_the_picture_of_the_stages(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = plain_settings();
    settings.quantity = LK_IRRADIANCE;
    assert_fuses("irradiance", &settings);
    settings.quantity = LK_RADIANCE;
    settings.brdf = LK_BRDF_PHONG;
    assert_fuses("Phong", &settings);
    settings.depth = 1;
    assert_fuses("depth 1", &settings);
}

// Which rays a pane lets by hangs on their last bits.
static void panes_colour_what_goes_through(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = plain_settings();
    choice_always_fuses = true;
    const struct estimate fused = estimate_image(glazed, &settings, 6);
    const struct estimate bare = estimate_image(scene, &settings, 6);
    settings.profile = true;
    const struct estimate stages = estimate_image(glazed, &settings, 6);
    assert_same_mean("a coloured pane", fused, stages);
    assert_true(fused.mean < bare.mean - 4.0 * (fused.error + bare.error));
}

static void the_queue_changes_no_bit(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = plain_settings();
    struct lk_image *whole = render_by(&settings, true);
    settings.queue = 1024;
    struct lk_image *parts = render_by(&settings, true);
    assert_true(is_same_image(whole, parts));
    lk_image_free(parts);
    lk_image_free(whole);
}

static void forms_that_are_forced_are_kept(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = plain_settings();
    settings.trace = LK_TRACE_PERSISTENT;
    struct lk_image *image = render_by(&settings, true);
    const struct lk_tracing *tracing = lk_image_info(image)->devices[0].tracing;
    for (int i = 0; i < LK_RAYS_COUNT; i++)
        assert_int_equal(tracing[i].trace, LK_TRACE_PERSISTENT);
    lk_image_free(image);
}

static void timed_kernels_are_stages(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = plain_settings();
    settings.profile = true;
    choice_always_fuses = true;
    struct lk_image *image = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(image);
    bool found = false;
    for (uint32_t i = 0; i < info->kernel_count; i++) {
        assert_string_not_equal(info->kernels[i].name, "bounce");
        found = found || strcmp(info->kernels[i].name, "material") == 0;
    }
    assert_true(found);
    lk_image_free(image);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_teardown(any_sampler_gives_the_picture_of_the_stages, stop_fusing),
        cmocka_unit_test_teardown(any_quantity_and_depth_give_the_picture_of_the_stages,
                                  stop_fusing),
        cmocka_unit_test_teardown(panes_colour_what_goes_through, stop_fusing),
        cmocka_unit_test_teardown(the_queue_changes_no_bit, stop_fusing),
        cmocka_unit_test_teardown(forms_that_are_forced_are_kept, stop_fusing),
        cmocka_unit_test_teardown(timed_kernels_are_stages, stop_fusing),
    };
    return cmocka_run_group_tests(tests, make_scenes, free_scenes);
}
