// Equal input gives equal bits, whatever the queue, the memory and the variant of the kernels.

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

// A room with textures, masks, several materials and lights of every kind.
static int make_scene(void **state)
{
    (void)state;
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
    gltf_triangle(&writer, gltf_emitter(&writer, 0.2, 3.0, true),
                  (const float[]){-1, 0, 1, -0.5f, 0.4f, 1, -1, 0.6f, 1.2f});
    gltf_light(&writer, (const float[]){1, 1, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":2,\"range\":3}");
    gltf_light(&writer, (const float[]){-1, 1, 2}, (const float[]){0, 0, 0},
               "{\"type\":\"spot\",\"intensity\":5,\"spot\":{}}");
    gltf_light(&writer, (const float[]){1, 2, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"directional\",\"intensity\":1}");
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

// 3 samples a pixel, and a size that is no power of two.
static struct lk_settings small_settings(void)
{
    return test_settings(75, 53, 3);
}

static void assert_same_render(const struct lk_settings *a, const struct lk_settings *b)
{
    struct lk_image *first = render(scene, a);
    struct lk_image *second = render(scene, b);
    assert_true(is_same_image(first, second));
    lk_image_free(second);
    lk_image_free(first);
}

static void same_settings_give_the_same_bits(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = small_settings();
    assert_same_render(&settings, &settings);
}

static void picture_is_not_black_and_finite(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings settings = small_settings();
    const double mean = render_mean(scene, &settings);
    assert_true(isfinite(mean) && mean > 0.01);
}

static void another_seed_gives_other_noise(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    struct lk_image *first = render(scene, &settings);
    settings.seed = 1;
    struct lk_image *second = render(scene, &settings);
    struct lk_comparison comparison;
    assert_int_equal(lk_compare(&comparison, NULL, first, second), LK_OK);
    assert_true(comparison.rmse > 0.01 * comparison.mean[0]);
    lk_image_free(second);
    lk_image_free(first);
}

static void queue_does_not_matter(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings automatic = small_settings();
    const uint32_t queues[] = {1, 1000, 1024, 8192, 65536};
    for (size_t i = 0; i < sizeof(queues) / sizeof(queues[0]); i++) {
        struct lk_settings settings = automatic;
        settings.queue = queues[i];
        if (queues[i] == 1) { // one path at a time takes long, so there is one pixel
            settings.width = 2;
            settings.height = 1;
            struct lk_settings whole = settings;
            whole.queue = 0;
            assert_same_render(&whole, &settings);
        } else {
            assert_same_render(&automatic, &settings);
        }
    }
}

// Rays are counted on the device, over batches that the host does not wait for one by one.
static void queue_does_not_change_what_is_counted(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    struct lk_image *whole = render(scene, &settings);
    settings.queue = 1000;
    struct lk_image *parts = render(scene, &settings);
    const struct lk_render_info *a = lk_image_info(whole);
    const struct lk_render_info *b = lk_image_info(parts);
    assert_true(a->paths == 75 * 53 * 3 && a->paths == b->paths);
    assert_true(a->rays_camera == a->paths && a->rays_camera == b->rays_camera);
    assert_true(a->rays_indirect > 0 && a->rays_indirect == b->rays_indirect);
    assert_true(a->rays_directional > 0 && a->rays_directional == b->rays_directional);
    assert_true(a->rays_shadow > a->rays_directional && a->rays_shadow == b->rays_shadow);
    lk_image_free(parts);
    lk_image_free(whole);
}

// The variants compute the same, but a device's compiler may round an expression of one kernel
// otherwise than in another, and a path may then go another way. PoCL does not, so that bits are
// equal there; elsewhere the images may differ in few paths.
static void assert_same_picture(const struct lk_settings *a, const struct lk_settings *b)
{
    struct lk_image *first = render(scene, a);
    struct lk_image *second = render(scene, b);
    struct lk_comparison comparison;
    assert_int_equal(lk_compare(&comparison, NULL, first, second), LK_OK);
    if (strcmp(lk_image_info(first)->device.type, "cpu") == 0)
        assert_true(is_same_image(first, second));
    for (int i = 0; i < 3; i++)
        assert_true(fabs(comparison.mean[i] - comparison.reference_mean[i]) <
                    1e-3 * comparison.mean[i]);
    lk_image_free(second);
    lk_image_free(first);
}

// Counts the pixels that are farther apart than rounding takes them.
static uint32_t count_different(const struct lk_image *first, const struct lk_image *second)
{
    uint32_t width, height;
    uint32_t count = 0;
    const float *a = lk_image_pixels(first, &width, &height);
    const float *b = lk_image_pixels(second, &width, &height);
    for (uint32_t i = 0; i < width * height * 3; i += 3)
        count += fabsf(a[i] - b[i]) > 1e-3f * (a[i] + b[i]) + 1e-5f;
    return count;
}

// Asserts that both pictures are one but for the paths that rounding has sent another way.
static void assert_close_picture(const struct lk_settings *one, const struct lk_settings *other)
{
    struct lk_comparison comparison;
    struct lk_image *first = render(scene, one);
    struct lk_image *second = render(scene, other);
    assert_int_equal(lk_compare(&comparison, NULL, first, second), LK_OK);
    for (int i = 0; i < 3; i++)
        assert_true(fabs(comparison.mean[i] - comparison.reference_mean[i]) <
                    1e-2 * comparison.mean[i]);
    assert_true(count_different(first, second) < 0.02 * 75 * 53);
    lk_image_free(second);
    lk_image_free(first);
}

static void traversal_variants_agree(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings simple = small_settings();
    simple.trace = LK_TRACE_SIMPLE;
    for (simple.bvh = LK_BVH_BINARY; simple.bvh <= LK_BVH_COMPRESSED; simple.bvh++) {
        struct lk_settings persistent = simple;
        persistent.trace = LK_TRACE_PERSISTENT;
        assert_same_picture(&simple, &persistent);
    }
    simple.bvh = LK_BVH_BINARY;
    struct lk_settings texture = simple;
    texture.nodes = LK_NODES_TEXTURE;
    assert_same_picture(&simple, &texture);
}

// A wide BVH's tests round otherwise, so that a path in some thousands may go another way; builders
// change the order of tests only.
static void layouts_of_the_bvh_agree(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings binary = small_settings();
    struct lk_settings wider = binary;
    binary.bvh = LK_BVH_BINARY;
    binary.bvh_build = LK_BVH_BUILD_SBVH;
    for (wider.bvh = LK_BVH_WIDE; wider.bvh <= LK_BVH_COMPRESSED; wider.bvh++)
        assert_close_picture(&binary, &wider);
    struct lk_settings thesis = binary;
    thesis.bvh_build = LK_BVH_BUILD_THESIS;
    assert_same_render(&binary, &thesis);
}

// CPUs shade hits by eights where textures are in a pool, which rounds otherwise.
static void texture_variants_agree(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings pool = small_settings();
    struct lk_settings bound = pool;
    pool.textures = LK_TEXTURES_POOL;
    bound.textures = LK_TEXTURES_BOUND;
    assert_close_picture(&pool, &bound);
    struct lk_settings other = bound;
    other.queue = 1024;
    other.trace = LK_TRACE_PERSISTENT;
    assert_same_picture(&bound, &other);
}

// No ray of this scene meets two triangles at one distance, so the order of the tests is free.
static void hierarchy_does_not_matter(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings whole = small_settings();
    struct lk_settings other = whole;
    other.split_threshold = 0.5f;
    assert_same_render(&whole, &other);
    other = whole;
    other.leaf_size = 2;
    assert_same_render(&whole, &other);
    assert_same_render(&whole, &whole); // with the hierarchy built anew
}

static void profile_and_cache_do_not_matter(void **state)
{
    (void)state;
    skip_without_device();
    const struct lk_settings plain = small_settings();
    struct lk_settings other = plain;
    other.profile = true;
    assert_same_render(&plain, &other);
    other.profile = false;
    other.no_cache = true;
    assert_same_render(&plain, &other);
}

// Whether rays of every kind were traced in the same way.
static bool is_traced_alike(const struct lk_image *first, const struct lk_image *second)
{
    const struct lk_tracing *a = lk_image_info(first)->devices[0].tracing;
    const struct lk_tracing *b = lk_image_info(second)->devices[0].tracing;
    bool alike = true;
    for (int c = 0; c < LK_RAYS_COUNT; c++)
        alike = alike && a[c].trace == b[c].trace && a[c].bvh == b[c].bvh;
    return alike;
}

// Less memory may also leave a GPU fewer ways to trace, which may round otherwise.
static void less_memory_shortens_the_queue_only(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_settings settings = small_settings();
    struct lk_image *first = render(scene, &settings);
    const struct lk_memory memory = lk_image_info(first)->scene.memory;
    settings.memory_limit = memory.total_device - memory.rays / 2;
    struct lk_image *second = render(scene, &settings);
    const struct lk_render_info *info = lk_image_info(second);
    assert_true(info->settings.queue < lk_image_info(first)->settings.queue);
    assert_true(info->scene.memory.total_device <= settings.memory_limit);
    if (strcmp(info->device.type, "cpu") == 0 || is_traced_alike(first, second))
        assert_true(is_same_image(first, second));
    assert_true(count_different(first, second) < 0.02 * 75 * 53);
    lk_image_free(second);
    lk_image_free(first);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(picture_is_not_black_and_finite),
        cmocka_unit_test(same_settings_give_the_same_bits),
        cmocka_unit_test(another_seed_gives_other_noise),
        cmocka_unit_test(queue_does_not_matter),
        cmocka_unit_test(queue_does_not_change_what_is_counted),
        cmocka_unit_test(traversal_variants_agree),
        cmocka_unit_test(layouts_of_the_bvh_agree),
        cmocka_unit_test(texture_variants_agree),
        cmocka_unit_test(hierarchy_does_not_matter),
        cmocka_unit_test(profile_and_cache_do_not_matter),
        cmocka_unit_test(less_memory_shortens_the_queue_only),
    };
    return cmocka_run_group_tests(tests, make_scene, free_scene);
}
