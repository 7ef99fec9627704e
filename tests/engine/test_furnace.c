// Furnaces: where all that surrounds a point sends the same radiance, what the point sends back is
// its albedo.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "see.h"

#define PI       3.14159265358979323846
#define RADIANCE 2.0
#define ROUNDING 1e-4 // relative: float sums, and normals of 32 bits

static const float room_lo[] = {-1.0f, -1.5f, -2.0f};
static const float room_hi[] = {1.0f, 1.5f, 2.0f};

// ---- A closed room of one albedo whose walls emit

static struct lk_scene *make_furnace(double albedo)
{
    struct gltf_writer writer = {0};
    gltf_room(&writer, gltf_emitter(&writer, albedo, RADIANCE, false), room_lo, room_hi);
    gltf_camera(&writer, "inside", (const float[]){0.3f, 0.2f, 0.1f},
                (const float[]){1.0f, -1.0f, -2.0f}, 1.5);
    return gltf_load(&writer);
}

// With at most D shaded hits, a camera path sees the emission of its first hit, and each shaded hit
// adds the direct light of the walls, which is the emission of one more: L (1 + a + ... + a^D).
static double furnace_radiance(double albedo, uint32_t depth)
{
    double sum = 1.0;
    for (uint32_t k = 0; k < depth; k++)
        sum = 1.0 + albedo * sum;
    return RADIANCE * sum;
}

static void furnace_sums_the_series_of_its_depth(void **state)
{
    (void)state;
    skip_without_device();
    const double albedos[] = {0.0, 0.5, 0.8, 1.0};
    const uint32_t depths[] = {1, 2, 3, 5, 12};
    for (size_t a = 0; a < 4; a++) {
        struct lk_scene *scene = make_furnace(albedos[a]);
        for (size_t d = 0; d < 5; d++) {
            struct lk_settings settings = test_settings(32, 32, 128);
            char what[64];
            settings.depth = depths[d];
            snprintf(what, sizeof(what), "albedo %g, depth %u", albedos[a], depths[d]);

            assert_agrees(what, estimate_point(scene, &settings),
                          furnace_radiance(albedos[a], depths[d]), ROUNDING);
        }
        lk_scene_free(scene);
    }
}

static void furnace_holds_for_every_light_sampler(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_furnace(0.7);
    for (int sampler = LK_LIGHTS_TREE; sampler <= LK_LIGHTS_ALL; sampler++) {
        struct lk_settings settings = test_settings(32, 32, 64);
        settings.light_sampler = (enum lk_light_sampler)sampler;
        settings.depth = 4;
        settings.shadow_rays = 2;
        assert_agrees("sampler", estimate_point(scene, &settings), furnace_radiance(0.7, 4),
                      ROUNDING);
    }
    lk_scene_free(scene);
}

// E at a wall is pi times what arrives: of the first hit neither albedo nor emission counts.
static void furnace_irradiance_is_pi_times_what_arrives(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = make_furnace(0.6);
    for (uint32_t depth = 1; depth <= 4; depth++) {
        struct lk_settings settings = test_settings(32, 32, 128);
        settings.quantity = LK_IRRADIANCE;
        settings.depth = depth;
        assert_agrees("E", estimate_point(scene, &settings), PI * furnace_radiance(0.6, depth - 1),
                      ROUNDING);
    }
    lk_scene_free(scene);
}

// Whether Russian roulette ends paths early, late or never, the mean stays; and where it never
// does, every path of a room without openings has a ray to each of its hits.
static void roulette_changes_no_mean(void **state)
{
    (void)state;
    skip_without_device();
    const uint32_t roulettes[] = {0, 1, 3, 255};
    const uint32_t depth = 5;
    struct lk_scene *scene = make_furnace(0.5);
    for (size_t i = 0; i < 4; i++) {
        struct lk_settings settings = test_settings(32, 32, 128);
        settings.depth = depth;
        settings.roulette_depth = roulettes[i];
        assert_agrees("roulette", estimate_point(scene, &settings), furnace_radiance(0.5, depth),
                      ROUNDING);
        struct lk_image *image = render(scene, &settings);
        const struct lk_render_info *info = lk_image_info(image);
        if (roulettes[i] >= depth)
            assert_true(info->rays_indirect == info->rays_camera * (depth - 1));
        else
            assert_true(info->rays_indirect < info->rays_camera * (depth - 1));
        lk_image_free(image);
    }
    lk_scene_free(scene);
}

// ---- Mirrors

// A mirror below a lamp, seen from straight above, so that it shows the lamp.
static struct lk_scene *make_mirror(double diffuse)
{
    struct gltf_writer writer = {0};
    const int mirror = gltf_material(
        &writer,
        "{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":[%g,%g,%g,1],"
        "\"specularFactor\":[0.2,0.5,0.9],\"glossinessFactor\":1}}}",
        diffuse, diffuse, diffuse);
    gltf_floor(&writer, mirror, 0.0f, 1.0f, true);
    gltf_floor(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), 3.0f, 1.0f, false);
    gltf_camera_flat(&writer, "down", (const float[]){0, 2, 0}, (const float[]){0, 0, 0}, 1e-4);
    return gltf_load(&writer);
}

static void mirror_shows_the_lamp_times_its_colour(void **state)
{
    (void)state;
    skip_without_device();
    const double colors[] = {0.2, 0.5, 0.9};
    struct lk_scene *scene = make_mirror(0.0);
    for (uint32_t depth = 1; depth <= 3; depth++) {
        struct lk_settings settings = test_settings(4, 4, 2);
        settings.brdf = LK_BRDF_PHONG;
        settings.depth = depth;
        struct lk_image *image = render(scene, &settings);
        uint32_t width, height;
        const float *pixels = lk_image_pixels(image, &width, &height);
        for (uint32_t i = 0; i < 3 * width * height; i++)
            assert_true(fabs(pixels[i] - colors[i % 3] * RADIANCE) < 1e-5 * RADIANCE);
        lk_image_free(image);
    }
    lk_scene_free(scene);
}

static void mirror_over_a_diffuse_base_adds_both(void **state)
{
    (void)state;
    skip_without_device();
    // The lamp's four quarters, 1 m a side, stand over the point at 3 m (Howell's catalog, B-3).
    const double p = sqrt(1.0 + 1.0 / 9.0);
    const double factor = 4.0 * (2.0 / 3.0 / p * atan(1.0 / 3.0 / p)) / (2.0 * PI);
    struct lk_scene *scene = make_mirror(0.3);
    struct lk_settings settings = test_settings(32, 32, 256);
    settings.brdf = LK_BRDF_PHONG;
    settings.depth = 1;
    const double specular = (0.2 + 0.5 + 0.9) / 3.0;
    assert_agrees("diffuse + mirror", estimate_point(scene, &settings),
                  RADIANCE * (specular + 0.3 * factor), ROUNDING);
    lk_scene_free(scene);
}

// ---- The glTF BRDF in a room of constant radiance

struct surface {
    double metallic, roughness, base;
};

static double mix(double a, double b, double share)
{
    return a + (b - a) * share;
}

// Appendix B of the glTF 2.0 specification as it is written there, times NoL.
static double gltf_brdf_cos(const struct surface *s, const double *view, const double *light)
{
    double h[3];
    double length = 0.0;
    for (int i = 0; i < 3; i++) {
        h[i] = view[i] + light[i];
        length += h[i] * h[i];
    }
    length = sqrt(length);
    double voh = 0.0;
    for (int i = 0; i < 3; i++)
        voh += view[i] * h[i] / length;
    const double noh = h[1] / length;
    const double nol = light[1];
    const double nov = view[1];
    const double a2 = pow(s->roughness, 4.0);
    const double t = noh * noh * (a2 - 1.0) + 1.0;
    const double d = a2 / (PI * t * t);
    const double gl = 2.0 * nol / (nol + sqrt(a2 + (1.0 - a2) * nol * nol));
    const double gv = 2.0 * nov / (nov + sqrt(a2 + (1.0 - a2) * nov * nov));
    const double specular = d * gl * gv / (4.0 * nol * nov);
    const double grazing = pow(1.0 - voh, 5.0);
    const double metal = specular * (s->base + (1.0 - s->base) * grazing);
    const double dielectric = mix(s->base / PI, specular, 0.04 + 0.96 * grazing);
    return mix(dielectric, metal, s->metallic) * nol;
}

// Its integral over the hemisphere, by the midpoint rule in cosine and turn.
static double gltf_albedo(const struct surface *s, double angle_rad)
{
    enum { COSINES = 1000, TURNS = 1000 };
    const double view[3] = {sin(angle_rad), cos(angle_rad), 0.0};
    double sum = 0.0;
    for (int i = 0; i < COSINES; i++) {
        const double cosine = (i + 0.5) / COSINES;
        const double sine = sqrt(1.0 - cosine * cosine);
        for (int k = 0; k < TURNS; k++) {
            const double turn = PI * (k + 0.5) / TURNS; // the other half is its mirror image
            const double light[3] = {sine * cos(turn), cosine, sine * sin(turn)};
            sum += gltf_brdf_cos(s, view, light);
        }
    }
    return sum * 2.0 * PI / (COSINES * TURNS);
}

// What a floor within a black room that emits RADIANCE sends towards the camera, over RADIANCE.
static struct estimate see_albedo(const struct surface *s, double angle_rad)
{
    struct gltf_writer writer = {0};
    const int material = gltf_material(
        &writer,
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,1],\"metallicFactor\":%g,"
        "\"roughnessFactor\":%g}}",
        s->base, s->base, s->base, s->metallic, s->roughness);
    gltf_floor(&writer, material, 0.0f, 1.0f, true);
    gltf_room(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), room_lo, room_hi);
    gltf_camera_flat(
        &writer, "view",
        (const float[]){(float)(0.8 * sin(angle_rad)), (float)(0.8 * cos(angle_rad)), 0.0f},
        (const float[]){0, 0, 0}, 1e-3);
    struct lk_settings settings = test_settings(32, 32, 256);
    settings.depth = 1;
    const struct estimate seen = see_point(&writer, &settings);
    return (struct estimate){seen.mean / RADIANCE, seen.error / RADIANCE};
}

static void gltf_materials_match_the_specification_in_a_furnace(void **state)
{
    (void)state;
    skip_without_device();
    const struct surface surfaces[] = {
        {0.0, 1.0, 0.8}, {0.0, 0.3, 0.8}, {0.0, 0.5, 0.0}, {0.4, 0.6, 0.5},
        {1.0, 1.0, 1.0}, {1.0, 0.6, 1.0}, {1.0, 0.3, 0.5},
    };
    const double angles[] = {0.3, 1.3};
    for (size_t i = 0; i < sizeof(surfaces) / sizeof(surfaces[0]); i++)
        for (size_t k = 0; k < 2; k++) {
            const struct surface *s = &surfaces[i];
            char what[96];
            snprintf(what, sizeof(what), "metallic %g, roughness %g, base %g at %g rad",
                     s->metallic, s->roughness, s->base, angles[k]);
            // The midpoint rule is off by less than 1e-3 where the lobe is narrowest.
            assert_agrees(what, see_albedo(s, angles[k]), gltf_albedo(s, angles[k]), 1e-3);
        }
}

static void metals_reflect_no_more_than_arrives(void **state)
{
    (void)state;
    skip_without_device();
    const double roughness[] = {0.0, 0.05, 0.2, 0.5, 1.0};
    const double angles[] = {0.01, 0.8, 1.5};
    for (size_t i = 0; i < 5; i++)
        for (size_t k = 0; k < 3; k++) {
            const struct surface metal = {1.0, roughness[i], 1.0};
            const struct estimate seen = see_albedo(&metal, angles[k]);
            assert_true(seen.mean <= 1.0 + 4.0 * seen.error + ROUNDING);
            // A smooth one loses next to nothing to light that would leave it twice.
            if (roughness[i] <= 0.05)
                assert_true(seen.mean >= 0.98 - 4.0 * seen.error);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(furnace_sums_the_series_of_its_depth),
        cmocka_unit_test(furnace_holds_for_every_light_sampler),
        cmocka_unit_test(roulette_changes_no_mean),
        cmocka_unit_test(furnace_irradiance_is_pi_times_what_arrives),
        cmocka_unit_test(mirror_shows_the_lamp_times_its_colour),
        cmocka_unit_test(mirror_over_a_diffuse_base_adds_both),
        cmocka_unit_test(gltf_materials_match_the_specification_in_a_furnace),
        cmocka_unit_test(metals_reflect_no_more_than_arrives),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
