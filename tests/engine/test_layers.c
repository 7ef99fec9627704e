// Thin transmission, diffuse transmission, clearcoats and sheen: what they let through, add and
// keep.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "see.h"

#define RADIANCE 2.0
#define ROUNDING 2e-4 // relative: float sums, and normals of 32 bits

static const float origin[3] = {0.0f, 0.0f, 0.0f};
static const float room_lo[] = {-1.0f, -1.5f, -2.0f};
static const float room_hi[] = {1.0f, 1.5f, 2.0f};

// A smooth pane of one colour. Without a specular part what it lets by is the same at every angle.
static int add_glass(struct gltf_writer *writer, const double *color, double specular)
{
    return gltf_material(writer,
                         "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,1],"
                         "\"metallicFactor\":0,\"roughnessFactor\":0},\"extensions\":{"
                         "\"KHR_materials_transmission\":{\"transmissionFactor\":1},"
                         "\"KHR_materials_specular\":{\"specularFactor\":%g}}}",
                         color[0], color[1], color[2], specular);
}

// ---- Straight through

static void pane_shows_the_lamp_times_its_colour(void **state)
{
    (void)state;
    skip_without_device();
    const double color[] = {0.2, 0.5, 0.9};
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), 0.0f, 1.0f, true);
    gltf_floor(&writer, add_glass(&writer, color, 0.0), 0.5f, 1.0f, true);
    gltf_camera_flat(&writer, "down", (const float[]){0, 1, 0}, origin, 0.5);
    struct lk_settings settings = test_settings(64, 64, 64);
    settings.depth = 1;
    const struct rgb seen = see_rgb(&writer, &settings);
    const double chance = sqrt(0.1 / 0.9 / (64.0 * 64.0 * 64.0)); // of meeting the pane
    for (int k = 0; k < 3; k++)
        assert_agrees("seen", (struct estimate){seen.v[k], seen.v[k] * chance}, color[k] * RADIANCE,
                      ROUNDING);
}

// A floor below panes below a point light, seen from below them.
static struct rgb see_shadow(const double colors[][3], uint32_t pane_count, double specular)
{
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 5.0f, true);
    for (uint32_t i = 0; i < pane_count; i++)
        gltf_floor(&writer, add_glass(&writer, colors[i], specular), 0.5f + 0.1f * (float)i, 5.0f,
                   true);
    gltf_light(&writer, (const float[]){0.4f, 3.0f, -0.3f}, origin,
               "{\"type\":\"point\",\"intensity\":10}");
    // Wide enough that no two rays are the same float by float: what chance decides would be, too.
    gltf_camera_flat(&writer, "below", (const float[]){0, 0.25f, 0}, origin, 0.05);
    struct lk_settings settings = test_settings(64, 64, 16);
    settings.depth = 1;
    return see_rgb(&writer, &settings);
}

static void shadows_of_panes_multiply_whatever_their_order(void **state)
{
    (void)state;
    skip_without_device();
    const double there[][3] = {{0.2, 0.5, 0.9}, {0.7, 0.6, 0.1}};
    const double back[][3] = {{0.7, 0.6, 0.1}, {0.2, 0.5, 0.9}};
    const struct rgb free_way = see_shadow(there, 0, 0.0);
    const struct rgb one = see_shadow(there, 2, 0.0);
    const struct rgb other = see_shadow(back, 2, 0.0);
    for (int k = 0; k < 3; k++) {
        const double expected = free_way.v[k] * there[0][k] * there[1][k];
        assert_true(expected > 0.0);
        assert_agrees("one", (struct estimate){one.v[k], 0.0}, expected, ROUNDING);
        assert_agrees("other", (struct estimate){other.v[k], 0.0}, expected, ROUNDING);
    }
}

// More panes than a shadow ray takes shares of: chance decides, colour by colour.
static void many_panes_are_right_on_average(void **state)
{
    (void)state;
    skip_without_device();
    enum { PANES = 12 };
    double colors[PANES][3];
    double expected[3] = {1.0, 1.0, 1.0};
    for (int i = 0; i < PANES; i++)
        for (int k = 0; k < 3; k++) {
            colors[i][k] = 0.95 - 0.05 * ((i + k) % 3);
            expected[k] *= colors[i][k];
        }
    const struct rgb free_way = see_shadow(colors, 0, 0.0);
    const struct rgb seen = see_shadow((const double(*)[3])colors, PANES, 0.0);
    for (int k = 0; k < 3; k++) {
        const double p = 0.9 * 0.9 * 0.9 * 0.9; // of passing the last four, about
        const double error = expected[k] * sqrt((1.0 - p) / p / (64.0 * 64.0 * 16.0));
        assert_agrees("shadow", (struct estimate){seen.v[k] / free_way.v[k], error}, expected[k],
                      ROUNDING);
    }
}

static void panes_reflect_by_fresnel_what_they_do_not_let_by(void **state)
{
    (void)state;
    skip_without_device();
    const double white[][3] = {{1.0, 1.0, 1.0}};
    const double cosine = 3.0 / sqrt(9.0 + 0.16 + 0.09);
    const double expected = 0.96 * (1.0 - pow(1.0 - cosine, 5.0));
    const double free_way = see_shadow(white, 0, 1.0).v[0];
    assert_agrees("shadow", (struct estimate){see_shadow(white, 1, 1.0).v[0] / free_way, 0.0},
                  expected, ROUNDING);
}

// A lamp shines on a glossy floor that it also mirrors in: what light samples and bounces find
// through a pane is its colour times what they find without.
static struct estimate see_glossy(const double *color, enum lk_light_sampler sampler)
{
    struct gltf_writer writer = {0};
    const int metal = gltf_material(
        &writer, "{\"pbrMetallicRoughness\":{\"metallicFactor\":1,\"roughnessFactor\":0.5}}");
    gltf_floor(&writer, metal, 0.0f, 1.0f, true);
    if (color != NULL)
        gltf_floor(&writer, add_glass(&writer, color, 0.0), 0.5f, 5.0f, true);
    gltf_floor(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), 2.0f, 0.7f, false);
    gltf_camera_flat(&writer, "below", (const float[]){0.2f, 0.4f, 0}, origin, 1e-3);
    struct lk_settings settings = test_settings(32, 32, 256);
    settings.light_sampler = sampler;
    settings.depth = 1;
    return see_point(&writer, &settings);
}

static void panes_tint_lamps_the_same_for_every_way_to_find_them(void **state)
{
    (void)state;
    skip_without_device();
    const double grey[] = {0.6, 0.6, 0.6};
    const double color[] = {0.9, 0.6, 0.3}; // the mean over channels is the same
    const struct estimate free_way = see_glossy(NULL, LK_LIGHTS_TREE);
    const struct estimate expected = {0.6 * free_way.mean, 0.6 * free_way.error};
    for (int sampler = LK_LIGHTS_TREE; sampler <= LK_LIGHTS_IMPORTANCE; sampler++) {
        assert_same_mean("grey", see_glossy(grey, (enum lk_light_sampler)sampler), expected);
        assert_same_mean("colour", see_glossy(color, (enum lk_light_sampler)sampler), expected);
    }
}

// ---- In a room of constant radiance

// What a level sheet of a material sends to a camera, over RADIANCE: mean over channels.
static struct estimate see_sheet(int material, struct gltf_writer *writer, double angle_rad)
{
    gltf_floor(writer, material, 0.0f, 0.9f, true);
    gltf_room(writer, gltf_emitter(writer, 0.0, RADIANCE, false), room_lo, room_hi);
    gltf_camera_flat(
        writer, "view",
        (const float[]){(float)(0.5 * sin(angle_rad)), (float)(0.5 * cos(angle_rad)), 0.0f}, origin,
        1e-3);
    struct lk_settings settings = test_settings(32, 32, 256);
    settings.depth = 1;
    const struct estimate seen = see_point(writer, &settings);
    return (struct estimate){seen.mean / RADIANCE, seen.error / RADIANCE};
}

static struct estimate see_layers(double angle_rad, double base, double metallic, double roughness,
                                  const char *extensions)
{
    struct gltf_writer writer = {0};
    const int material = gltf_material(
        &writer,
        "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%g,%g,%g,1],\"metallicFactor\":%g,"
        "\"roughnessFactor\":%g},\"extensions\":{%s}}",
        base, base, base, metallic, roughness, extensions);
    return see_sheet(material, &writer, angle_rad);
}

static void clear_glass_cannot_be_seen(void **state)
{
    (void)state;
    skip_without_device();
    const double angles[] = {0.1, 0.9, 1.3};
    for (int i = 0; i < 3; i++)
        assert_agrees("smooth",
                      see_layers(angles[i], 1.0, 0.0, 0.0,
                                 "\"KHR_materials_transmission\":{\"transmissionFactor\":1}"),
                      1.0, 2e-3); // the mirror's lobe is as wide as that of roughness 0.03
}

static void blurred_glass_lets_through_what_a_white_metal_mirrors(void **state)
{
    (void)state;
    skip_without_device();
    const double roughness[] = {0.1, 0.3, 0.6, 1.0};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 2; k++) {
            const double angle_rad = 0.2 + k;
            const struct estimate metal = see_layers(angle_rad, 1.0, 1.0, roughness[i], "");
            const struct estimate glass =
                see_layers(angle_rad, 1.0, 0.0, roughness[i],
                           "\"KHR_materials_transmission\":{\"transmissionFactor\":1},"
                           "\"KHR_materials_specular\":{\"specularFactor\":0}");
            assert_same_mean("glass", glass, metal);
            assert_true(glass.mean <= 1.0 + 4.0 * glass.error);
        }
}

static void diffuse_transmission_shares_what_a_sheet_scatters(void **state)
{
    (void)state;
    skip_without_device();
    const double factors[] = {0.0, 0.3, 1.0};
    for (int i = 0; i < 3; i++) {
        char extensions[256];
        snprintf(extensions, sizeof(extensions),
                 "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":%g,"
                 "\"diffuseTransmissionColorFactor\":[0.4,0.4,0.4]},"
                 "\"KHR_materials_specular\":{\"specularFactor\":0}",
                 factors[i]);
        assert_agrees("sheet", see_layers(0.5, 0.8, 0.0, 1.0, extensions),
                      0.8 * (1.0 - factors[i]) + 0.4 * factors[i], ROUNDING);
    }
}

static void clearcoat_mirrors_by_fresnel_and_dims_the_base(void **state)
{
    (void)state;
    skip_without_device();
    const double angles[] = {0.1, 0.8, 1.3};
    for (int i = 0; i < 3; i++) {
        const double share = 0.7 * (0.04 + 0.96 * pow(1.0 - cos(angles[i]), 5.0));
        assert_agrees("coat",
                      see_layers(angles[i], 0.5, 0.0, 1.0,
                                 "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.7},"
                                 "\"KHR_materials_specular\":{\"specularFactor\":0}"),
                      0.5 * (1.0 - share) + share, 2e-3);
    }
}

// White under white: what the sheen does not send back the base does. The table's steps, and what
// is lost where the formulas would send back too much.
static void sheen_over_white_can_hardly_be_seen(void **state)
{
    (void)state;
    skip_without_device();
    const double angles[] = {0.0, 0.7, 1.2, 1.5};
    const double roughness[] = {0.0, 0.3, 0.6, 1.0};
    for (int i = 0; i < 4; i++)
        for (int k = 0; k < 4; k++) {
            char extensions[192];
            snprintf(extensions, sizeof(extensions),
                     "\"KHR_materials_sheen\":{\"sheenColorFactor\":[1,1,1],"
                     "\"sheenRoughnessFactor\":%g},"
                     "\"KHR_materials_specular\":{\"specularFactor\":0}",
                     roughness[k]);
            const struct estimate seen = see_layers(angles[i], 1.0, 0.0, 1.0, extensions);
            assert_true(seen.mean <= 1.01 + 4.0 * seen.error);
            if (roughness[k] >= 0.3)
                assert_agrees("sheet", seen, 1.0, 0.02);
        }
}

// The coat's own map turns it alone: smooth and whole over black, it shows what a metal with that
// map does, by Fresnel of the turned normal.
static struct rgb see_mapped(const char *format, double angle_rad)
{
    static const float positions[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    static const float normals[] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    static const float texcoords[] = {0, 0, 0, 1, 1, 1, 1, 0};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const uint8_t texel[4] = {170, 100, 240, 255};
    struct gltf_writer writer = {0};
    const int map = gltf_texture(&writer, texel, 1, 1);
    char text[512];
    snprintf(text, sizeof(text), format, map);
    const struct gltf_mesh mesh = {.positions = positions,
                                   .normals = normals,
                                   .texcoords = texcoords,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    gltf_node(&writer, "{\"mesh\":%d}",
              gltf_mesh(&writer, gltf_material(&writer, "%s", text), &mesh));
    gltf_light(&writer, (const float[]){1.2f, 2.0f, 0.9f}, origin,
               "{\"type\":\"directional\",\"intensity\":1}");
    gltf_camera_flat(&writer, "view",
                     (const float[]){(float)sin(angle_rad), (float)cos(angle_rad), 0}, origin,
                     1e-3);
    struct lk_settings settings = test_settings(32, 32, 64);
    settings.depth = 1;
    return see_rgb(&writer, &settings);
}

static void clearcoat_follows_its_own_normal_map(void **state)
{
    (void)state;
    skip_without_device();
    const double angles[] = {-0.5, 0.0, 0.4};
    for (int i = 0; i < 3; i++) {
        const struct rgb metal = see_mapped("{\"normalTexture\":{\"index\":%d,\"scale\":0.7},"
                                            "\"pbrMetallicRoughness\":{\"roughnessFactor\":0.6}}",
                                            angles[i]);
        const struct rgb coat = see_mapped(
            "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1],\"metallicFactor\":0},"
            "\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0},"
            "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1,"
            "\"clearcoatRoughnessFactor\":0.6,"
            "\"clearcoatNormalTexture\":{\"index\":%d,\"scale\":0.7}}}}",
            angles[i]);
        const double n[3] = {0.7 * (2.0 * 170 / 255 - 1), 2.0 * 240 / 255 - 1,
                             -0.7 * (2.0 * 100 / 255 - 1)};
        const double cosine = (sin(angles[i]) * n[0] + cos(angles[i]) * n[1]) /
                              sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
        const double share = 0.04 + 0.96 * pow(1.0 - cosine, 5.0);
        const double error = share * sqrt((1.0 - 0.25) / 0.25 / (32.0 * 32.0 * 64.0));
        assert_true(metal.v[0] > 0.01);
        assert_agrees("coat", (struct estimate){coat.v[0] / metal.v[0], error}, share, 1e-3);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pane_shows_the_lamp_times_its_colour),
        cmocka_unit_test(shadows_of_panes_multiply_whatever_their_order),
        cmocka_unit_test(many_panes_are_right_on_average),
        cmocka_unit_test(panes_reflect_by_fresnel_what_they_do_not_let_by),
        cmocka_unit_test(panes_tint_lamps_the_same_for_every_way_to_find_them),
        cmocka_unit_test(clear_glass_cannot_be_seen),
        cmocka_unit_test(blurred_glass_lets_through_what_a_white_metal_mirrors),
        cmocka_unit_test(diffuse_transmission_shares_what_a_sheet_scatters),
        cmocka_unit_test(clearcoat_mirrors_by_fresnel_and_dims_the_base),
        cmocka_unit_test(sheen_over_white_can_hardly_be_seen),
        cmocka_unit_test(clearcoat_follows_its_own_normal_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
