// Samplers, light samplers, shadow rays and multiple importance sampling change the noise, never
// the mean.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "gltf_writer.h"
#include "render_support.h"

#define SEEDS 16 // renders that estimate a mean and its standard error

static const float eye[3] = {0.5f, 2.0f, 5.5f};
static const float middle[3] = {0.0f, 0.8f, 0.0f};

// A grey glTF material.
static int add_metal(struct gltf_writer *writer, double metallic, double roughness)
{
    return gltf_material(writer,
                         "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.7,0.6,0.5,1],"
                         "\"metallicFactor\":%g,\"roughnessFactor\":%g}}",
                         metallic, roughness);
}

// A floor, a back wall and an upright sheet between lights of every kind of the tree, with a range
// and without.
static void add_stage(struct gltf_writer *writer, double roughness)
{
    gltf_floor(writer, add_metal(writer, 0.0, roughness), 0.0f, 4.0f, true);
    gltf_quad(writer, gltf_lambert(writer, 0.6),
              (const float[]){-4, 0, -4, 4, 0, -4, 4, 4, -4, -4, 4, -4});
    gltf_quad(writer, add_metal(writer, 1.0, roughness),
              (const float[]){-1, 0, -1, 1, 0, -1.5f, 1, 1.5f, -1.5f, -1, 1.5f, -1});
    gltf_camera(writer, "front", eye, middle, 0.9);
}

static void add_punctual_lights(struct gltf_writer *writer)
{
    static const float at[][3] = {{-3, 2, 1}, {2, 1.2f, 1}, {-2, 1, 2}, {3, 3, -2}, {0, 2.5f, -2}};
    const double ranges[] = {2.5, 3.0, 4.0, 6.0, 5.0};
    for (int i = 0; i < 5; i++)
        gltf_light(writer, at[i], middle,
                   "{\"type\":\"point\",\"intensity\":%d,\"color\":[1,0.5,0.25],\"range\":%g}",
                   3 + i, ranges[i]);
    gltf_light(writer, (const float[]){1, 3, 2}, middle, "{\"type\":\"point\",\"intensity\":4}");
    gltf_light(writer, (const float[]){-1, 3, 3}, middle,
               "{\"type\":\"spot\",\"intensity\":20,\"range\":7,\"spot\":{}}");
    gltf_light(writer, (const float[]){2, 2, 3}, middle,
               "{\"type\":\"spot\",\"intensity\":15,\"spot\":{\"innerConeAngle\":0.1,"
               "\"outerConeAngle\":0.4}}");
}

static void add_surface_lights(struct gltf_writer *writer)
{
    gltf_quad(writer, gltf_emitter(writer, 0.3, 4.0, false),
              (const float[]){-2, 0.2f, 0, -2, 0.2f, 1, -2, 1.2f, 1, -2, 1.2f, 0});
    gltf_triangle(writer, gltf_emitter(writer, 0.3, 6.0, true),
                  (const float[]){1.8f, 0.6f, 0.2f, 1.8f, 0.6f, 1.2f, 2.3f, 1.4f, 0.6f});
}

// All of it.
static struct lk_scene *make_stage(void)
{
    struct gltf_writer writer = {0};
    add_stage(&writer, 0.4);
    add_punctual_lights(&writer);
    add_surface_lights(&writer);
    return gltf_load(&writer);
}

static struct lk_settings stage_settings(enum lk_light_sampler sampler, uint32_t shadow_rays)
{
    struct lk_settings settings = test_settings(48, 48, 16);
    settings.depth = 3;
    settings.light_sampler = sampler;
    settings.shadow_rays = shadow_rays;
    return settings;
}

// The mean of make_stage(); what several tests ask for, one shadow ray, is rendered once.
static struct estimate stage_mean(struct lk_scene *scene, enum lk_light_sampler sampler,
                                  uint32_t shadow_rays)
{
    static struct estimate seen[LK_LIGHTS_IMPORTANCE + 1]; // error 0: not yet
    if (shadow_rays == 1 && seen[sampler].error > 0.0)
        return seen[sampler];
    const struct lk_settings settings = stage_settings(sampler, shadow_rays);
    const struct estimate mean = estimate_image(scene, &settings, SEEDS);
    if (shadow_rays == 1)
        seen[sampler] = mean;
    return mean;
}

static void samplers_agree_in_the_mean(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_stage();
    const struct estimate exact = stage_mean(scene, LK_LIGHTS_ALL, 1);
    for (uint32_t rays = 1; rays <= 4; rays += 3) {
        assert_same_mean("tree", stage_mean(scene, LK_LIGHTS_TREE, rays), exact);
        assert_same_mean("uniform", stage_mean(scene, LK_LIGHTS_UNIFORM, rays), exact);
        assert_same_mean("importance", stage_mean(scene, LK_LIGHTS_IMPORTANCE, rays), exact);
    }
    lk_scene_free(scene);
}

// With no light that a bounce could hit, nothing but the choice of lights is left to differ.
static void samplers_agree_on_punctual_lights_alone(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    add_stage(&writer, 1.0);
    add_punctual_lights(&writer);
    struct lk_scene *scene = gltf_load(&writer);

    struct estimate seen[LK_LIGHTS_IMPORTANCE + 1];
    for (int sampler = LK_LIGHTS_TREE; sampler <= LK_LIGHTS_IMPORTANCE; sampler++) {
        const struct lk_settings settings = stage_settings((enum lk_light_sampler)sampler, 1);
        seen[sampler] = estimate_image(scene, &settings, SEEDS);
    }
    assert_same_mean("tree", seen[LK_LIGHTS_TREE], seen[LK_LIGHTS_ALL]);
    assert_same_mean("uniform", seen[LK_LIGHTS_UNIFORM], seen[LK_LIGHTS_ALL]);
    assert_same_mean("importance", seen[LK_LIGHTS_IMPORTANCE], seen[LK_LIGHTS_ALL]);
    lk_scene_free(scene);
}

// The weights of both ways to a lamp must sum to one however often light samples try for it: a
// smooth surface finds it by bounces, a rough one by light samples.
static void weights_of_both_ways_to_a_lamp_sum_to_one(void **state)
{
    (void)state;
    skip_without_device();
    const double roughness[] = {0.1, 0.5};
    for (int i = 0; i < 2; i++) {
        struct gltf_writer writer = {0};
        char what[64];
        add_stage(&writer, roughness[i]);
        add_surface_lights(&writer);
        struct lk_scene *scene = gltf_load(&writer);
        const struct lk_settings all = stage_settings(LK_LIGHTS_ALL, 1);
        const struct lk_settings many = stage_settings(LK_LIGHTS_UNIFORM, 16);
        const struct lk_settings tree = stage_settings(LK_LIGHTS_TREE, 1);
        const struct lk_settings importance = stage_settings(LK_LIGHTS_IMPORTANCE, 1);
        const struct estimate exact = estimate_image(scene, &all, SEEDS);
        snprintf(what, sizeof(what), "16 rays, roughness %g", roughness[i]);
        assert_same_mean(what, estimate_image(scene, &many, SEEDS), exact);
        snprintf(what, sizeof(what), "tree, roughness %g", roughness[i]);
        assert_same_mean(what, estimate_image(scene, &tree, SEEDS), exact);
        snprintf(what, sizeof(what), "importance, roughness %g", roughness[i]);
        assert_same_mean(what, estimate_image(scene, &importance, SEEDS), exact);
        lk_scene_free(scene);
    }
}

// Variance of a pixel: half the mean squared difference of two independent renders.
static double pixel_variance(struct lk_scene *scene, struct lk_settings settings)
{
    struct lk_comparison comparison;
    settings.seed = 1;
    struct lk_image *a = render(scene, &settings);
    settings.seed = 2;
    struct lk_image *b = render(scene, &settings);
    assert_int_equal(lk_compare(&comparison, NULL, a, b), LK_OK);
    lk_image_free(b);
    lk_image_free(a);
    return 0.5 * comparison.variance;
}

static void more_shadow_rays_lower_the_variance(void **state)
{
    (void)state;
    skip_without_device();
    static const float at[][3] = {{-1, 2, -1}, {1, 2, -1}, {-1, 2, 1}, {1, 2, 1}};
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 4.0f, true);
    for (int i = 0; i < 4; i++)
        gltf_light(&writer, at[i], middle, "{\"type\":\"point\",\"intensity\":%d}", 1 + 4 * i);
    gltf_camera_flat(&writer, "down", (const float[]){0, 1, 0}, (const float[]){0, 0, 0}, 1.0);
    struct lk_scene *scene = gltf_load(&writer);
    struct lk_settings settings = test_settings(64, 64, 16);
    settings.depth = 1; // what varies is the light taken and, far less, the place in the pixel
    settings.light_sampler = LK_LIGHTS_UNIFORM;
    settings.sampler = LK_SAMPLER_RANDOM;
    const double one = pixel_variance(scene, settings);
    settings.shadow_rays = 4;
    const double four = pixel_variance(scene, settings);

    // Each variance comes from 4096 pixels of one difference each: it is 2 % off by chance, their
    // ratio 3 %. Independent rays give a quarter.
    if (!(four > 0.9 * one / 4.0 && four < 1.1 * one / 4.0))
        fail_msg("the variance is %g with 1 ray and %g with 4", one, four);

    // Spread samples are so among the rays of a hit, too: each of the four lights gets its share.
    settings.sampler = LK_SAMPLER_SOBOL;
    settings.spp = 1;
    const double spread = pixel_variance(scene, settings);
    assert_true(spread < 0.1 * 16.0 * four);
    lk_scene_free(scene);
}

static void spread_samples_have_less_noise_and_the_same_mean(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_stage();
    for (int sampler = LK_LIGHTS_TREE; sampler <= LK_LIGHTS_IMPORTANCE; sampler++) {
        struct lk_settings spread = stage_settings((enum lk_light_sampler)sampler, 1);
        struct lk_settings random = spread;
        random.sampler = LK_SAMPLER_RANDOM;
        assert_same_mean("spread", stage_mean(scene, (enum lk_light_sampler)sampler, 1),
                         estimate_image(scene, &random, SEEDS));
        assert_true(pixel_variance(scene, spread) < 0.8 * pixel_variance(scene, random));
    }
    lk_scene_free(scene);
}

// Pearson's correlation.
static double correlation(const double *a, const double *b, uint32_t count)
{
    double mean_a = 0.0, mean_b = 0.0, aa = 0.0, bb = 0.0, ab = 0.0;
    for (uint32_t i = 0; i < count; i++) {
        mean_a += a[i] / count;
        mean_b += b[i] / count;
    }
    for (uint32_t i = 0; i < count; i++) {
        aa += (a[i] - mean_a) * (a[i] - mean_a);
        bb += (b[i] - mean_b) * (b[i] - mean_b);
        ab += (a[i] - mean_a) * (b[i] - mean_b);
    }
    return ab / sqrt(aa * bb);
}

// Pixels that all look at one point share the points of their samples, shifted: what is wrong with
// one tells nothing of its neighbours, nor of the same pixel under another seed.
static void noise_of_pixels_and_seeds_is_independent(void **state)
{
    (void)state;
    skip_without_device();
    enum { SIZE = 64, PIXELS = SIZE * SIZE };
    struct gltf_writer writer = {0};
    add_stage(&writer, 0.4);
    add_surface_lights(&writer);
    gltf_camera_flat(&writer, "point", (const float[]){0.1f, 1.0f, 0.4f},
                     (const float[]){0.1f, 0.0f, 0.4f}, 1e-4);
    struct lk_scene *scene = gltf_load(&writer);
    double seen[2][PIXELS];
    for (uint32_t seed = 0; seed < 2; seed++) {
        struct lk_settings settings = test_settings(SIZE, SIZE, 4);
        settings.camera = "point";
        settings.seed = seed;
        struct lk_image *image = render(scene, &settings);
        uint32_t width, height;
        const float *rgb = lk_image_pixels(image, &width, &height);
        for (uint32_t i = 0; i < PIXELS; i++)
            seen[seed][i] = rgb[3 * i];
        lk_image_free(image);
    }
    const double chance = 5.0 / SIZE; // five times the spread of unrelated numbers
    assert_true(fabs(correlation(seen[0], seen[1], PIXELS)) < chance);
    assert_true(fabs(correlation(seen[0], seen[0] + 1, PIXELS - 1)) < chance);
    assert_true(fabs(correlation(seen[0], seen[0] + SIZE, PIXELS - SIZE)) < chance);
    assert_true(fabs(correlation(seen[0], seen[0] + SIZE + 1, PIXELS - SIZE - 1)) < chance);
    lk_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(samplers_agree_in_the_mean),
        cmocka_unit_test(samplers_agree_on_punctual_lights_alone),
        cmocka_unit_test(weights_of_both_ways_to_a_lamp_sum_to_one),
        cmocka_unit_test(more_shadow_rays_lower_the_variance),
        cmocka_unit_test(spread_samples_have_less_noise_and_the_same_mean),
        cmocka_unit_test(noise_of_pixels_and_seeds_is_independent),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
