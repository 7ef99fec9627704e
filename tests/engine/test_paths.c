// One stage that takes whole paths computes what the stages apart compute, among few triangles that
// are all Lambert.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <string.h>

#include "gltf_writer.h"
#include "render_support.h"

#define WIDTH  47u // no multiple of what runs side by side
#define HEIGHT 31u

static struct lk_scene *scene; // of the group

// A room that is open in front, with textures, shading normals, halves of quads, single triangles
// and two that lie in each other, and lights that shine on one side, on both, through a texture,
// and from points.
static int make_scene(void **state)
{
    (void)state;
    static const uint8_t texels[] = {255, 10, 0, 255, 20, 128, 60,  255,
                                     3,   40, 9, 255, 80, 200, 250, 255};
    static const float positions[] = {-1, -0.9f, 0.2f, 1, -0.9f, 0, 1, 0.9f, 0, -1, 1, -0.1f};
    static const float texcoords[] = {0, 2, 2, 2, 2, 0, 0, 0};
    static const float normals[] = {-0.6f, 0, 0.8f, 0.6f, 0, 0.8f, 0.6f, 0, 0.8f, -0.6f, 0, 0.8f};
    static const float panel[] = {-1.9f, 0, -1, -1.9f, 0, 0, -1.9f, 1, 0, -1.9f, 1, -1};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const float walls[][12] = {{-2, -1, -2, 2, -1, -2, 2, 2, -2, -2, 2, -2},
                                      {-2, -1, 3, -2, -1, -2, -2, 2, -2, -2, 2, 3},
                                      {2, -1, -2, 2, -1, 3, 2, 2, 3, 2, 2, -2}};
    struct gltf_writer writer = {0};
    const struct gltf_mesh mesh = {.positions = positions,
                                   .normals = normals,
                                   .texcoords = texcoords,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    const int textured =
        gltf_material(&writer,
                      "{\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"baseColorTexture\":"
                      "{\"index\":%d}},\"extensions\":{\"KHR_materials_specular\":"
                      "{\"specularFactor\":0}}}",
                      gltf_texture(&writer, texels, 2, 2));
    const struct gltf_mesh shining = {.positions = panel,
                                      .texcoords = texcoords,
                                      .triangles = triangles,
                                      .vertex_count = 4,
                                      .triangle_count = 2};
    const int glow = gltf_material(
        &writer,
        "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"doubleSided\":true,"
        "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":%d},\"extensions\":"
        "{\"KHR_materials_specular\":{\"specularFactor\":0}}}",
        gltf_texture(&writer, texels, 2, 2));
    gltf_node(&writer, "{\"mesh\":%d}", gltf_mesh(&writer, textured, &mesh));
    gltf_node(&writer, "{\"mesh\":%d}", gltf_mesh(&writer, glow, &shining));
    gltf_triangle(&writer, gltf_lambert(&writer, 0.9),
                  (const float[]){0.2f, -0.5f, 1, 1, -0.4f, 1, 0.7f, 0.5f, 1});
    gltf_triangle(&writer, gltf_lambert(&writer, 0.1), // the same from another corner
                  (const float[]){1, -0.4f, 1, 0.2f, -0.5f, 1, 0.7f, 0.5f, 1});
    const int white = gltf_lambert(&writer, 0.7);
    for (size_t i = 0; i < sizeof(walls) / sizeof(walls[0]); i++)
        gltf_quad(&writer, white, walls[i]);
    gltf_floor(&writer, gltf_lambert(&writer, 0.4), -1.0f, 2.0f, true);
    gltf_floor(&writer, gltf_emitter(&writer, 0.2, 3.0, false), 1.9f, 0.6f, false);
    gltf_triangle(&writer, gltf_emitter(&writer, 0.2, 3.0, true),
                  (const float[]){-1, 0, 1, -0.5f, 0.4f, 1, -1, 0.6f, 1.2f});
    gltf_light(&writer, (const float[]){1, 1, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":2,\"range\":3}");
    gltf_light(&writer, (const float[]){-1, 1, 2}, (const float[]){0, 0, 0},
               "{\"type\":\"spot\",\"intensity\":5,\"spot\":{}}");
    gltf_camera(&writer, "front", (const float[]){0.1f, 0.3f, 2.9f}, (const float[]){0, 0.2f, 0},
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

// 5 samples a pixel, traced as the device does by itself.
static struct lk_settings small_settings(void)
{
    struct lk_settings settings = test_settings(WIDTH, HEIGHT, 5);
    settings.trace = LK_TRACE_AUTO;
    settings.bvh = LK_BVH_AUTO;
    return settings;
}

// Asserts that the picture, and the rays that it takes, do not depend on whether the stages are
// apart. A ray that meets a triangle's very edge may be found to miss its box by a traversal, so
// that few pixels may be others.
static void assert_same_apart(const struct lk_settings *settings)
{
    struct lk_settings apart = *settings;
    apart.trace = LK_TRACE_SIMPLE;
    struct lk_image *first = render(scene, settings);
    struct lk_image *second = render(scene, &apart);
    const struct lk_render_info *one = lk_image_info(first);
    const struct lk_render_info *other = lk_image_info(second);
    uint32_t width, height;
    uint32_t others = 0;
    const float *a = lk_image_pixels(first, &width, &height);
    const float *b = lk_image_pixels(second, &width, &height);
    for (uint32_t i = 0; i < 3 * width * height; i += 3)
        others += memcmp(&a[i], &b[i], 3 * sizeof(*a)) != 0;
    if (strcmp(one->device.type, "cpu") == 0) {
        assert_true(one->devices[0].fused);
        assert_false(other->devices[0].fused);
        assert_true(others <= WIDTH * HEIGHT / 500);
        assert_int_equal(one->rays_camera, other->rays_camera);
        assert_true(fabs((double)one->rays_indirect - (double)other->rays_indirect) <=
                    10.0 * others);
        assert_true(fabs((double)one->rays_shadow - (double)other->rays_shadow) <= 50.0 * others);
    }
    assert_true(image_mean(first) > 0.01);
    lk_image_free(second);
    lk_image_free(first);
}

static void samplers_agree(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    for (settings.light_sampler = LK_LIGHTS_AUTO; settings.light_sampler <= LK_LIGHTS_IMPORTANCE;
         settings.light_sampler++)
        for (settings.shadow_rays = 1; settings.shadow_rays <= 3; settings.shadow_rays += 2)
            assert_same_apart(&settings);
}

static void depths_and_quantities_agree(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    settings.roulette_depth = 2;
    for (settings.depth = 1; settings.depth <= 7; settings.depth += 3)
        for (settings.quantity = LK_RADIANCE; settings.quantity <= LK_DIRECT; settings.quantity++)
            assert_same_apart(&settings);
}

static void random_samples_agree(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    settings.sampler = LK_SAMPLER_RANDOM;
    settings.seed = 7;
    assert_same_apart(&settings);
}

static void queue_does_not_matter(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    struct lk_image *whole = render(scene, &settings);
    for (settings.queue = 1000; settings.queue < 4000; settings.queue += 999) {
        struct lk_image *cut = render(scene, &settings);
        assert_true(is_same_image(whole, cut));
        lk_image_free(cut);
    }
    lk_image_free(whole);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samplers_agree),
        cmocka_unit_test(depths_and_quantities_agree),
        cmocka_unit_test(random_samples_agree),
        cmocka_unit_test(queue_does_not_matter),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
