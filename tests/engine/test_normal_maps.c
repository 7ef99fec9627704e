// Normal maps: which way they tilt, on either side, in mirrored instances and with tangents from
// the file or our own.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdio.h>

#include "see.h"

#define TOLERANCE 3e-4 // relative: tangents and normals of 32 bits

static const float origin[3] = {0.0f, 0.0f, 0.0f};

// A normal map of one texel.
struct texel {
    uint8_t r, g, b;
};

// The tilted normal of a level floor seen from above with u to the right (x) and v down (z): green
// tilts up, away from v.
static void tilt(double *out, struct texel t, double scale)
{
    const double n[3] = {scale * (2.0 * t.r / 255.0 - 1.0), 2.0 * t.b / 255.0 - 1.0,
                         -scale * (2.0 * t.g / 255.0 - 1.0)};
    const double length = sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int k = 0; k < 3; k++)
        out[k] = n[k] / length;
}

// Radiance of a Lambert floor of albedo 0.5 with a normal map, in light of 1 lux from (1, 2, 1) or,
// from below, (1, -2, 1).
static double see_floor(struct texel t, double scale, const char *node, bool below, bool mirrored,
                        enum lk_quantity quantity)
{
    struct gltf_writer writer = {0};
    const uint8_t rgba[4] = {t.r, t.g, t.b, 255};
    const int map = gltf_texture(&writer, rgba, 1, 1);
    const int material =
        gltf_material(&writer,
                      "{\"normalTexture\":{\"index\":%d,\"scale\":%g},\"pbrMetallicRoughness\":{"
                      "\"baseColorFactor\":[0.5,0.5,0.5,1],\"metallicFactor\":0},"
                      "\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0}}}",
                      map, scale);
    static const float positions[] = {-1, 0, -1, -1, 0, 1, 1, 0, 1, 1, 0, -1};
    static const float normals[] = {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0};
    static const float straight[] = {0, 0, 0, 1, 1, 1, 1, 0};
    static const float turned[] = {1, 0, 1, 1, 0, 1, 0, 0}; // u the other way
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    const struct gltf_mesh mesh = {.positions = positions,
                                   .normals = normals,
                                   .texcoords = mirrored ? turned : straight,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    gltf_node(&writer, "{\"mesh\":%d%s}", gltf_mesh(&writer, material, &mesh), node);
    const float side = below ? -1.0f : 1.0f;
    gltf_light(&writer, (const float[]){1, 2.0f * side, 1}, origin,
               "{\"type\":\"directional\",\"intensity\":1}");
    gltf_camera_flat(&writer, "view", (const float[]){0, side, 0}, origin, 1e-3);
    struct lk_settings settings = test_settings(4, 4, 1);
    settings.depth = 1;
    settings.quantity = quantity;
    return see_mean(&writer, &settings);
}

static double expected_of(const double *normal, double x, double y, double z)
{
    return 0.5 / 3.14159265358979 * (normal[0] * x + normal[1] * y + normal[2] * z) / sqrt(6.0);
}

static void check(const char *what, double seen, double expected)
{
    assert_true(expected > 0.05);
    assert_agrees(what, (struct estimate){seen, 0.0}, expected, TOLERANCE);
}

static const struct texel texels[] = {{128, 128, 255},
                                      {180, 128, 230},
                                      {128, 190, 220},
                                      {90, 160, 220}};

static void red_tilts_along_u_and_green_against_v(void **state)
{
    (void)state;
    skip_without_device();
    for (int i = 0; i < 4; i++) {
        double n[3];
        tilt(n, texels[i], 1.0);
        check("floor", see_floor(texels[i], 1.0, "", false, false, LK_RADIANCE),
              expected_of(n, 1, 2, 1));
        tilt(n, texels[i], 0.4);
        check("scaled", see_floor(texels[i], 0.4, "", false, false, LK_RADIANCE),
              expected_of(n, 1, 2, 1));
    }
}

static void mirrored_coordinates_and_instances_mirror_the_tilt(void **state)
{
    (void)state;
    skip_without_device();
    for (int i = 0; i < 4; i++) {
        double n[3];
        tilt(n, texels[i], 1.0);
        check("u turned", see_floor(texels[i], 1.0, "", false, true, LK_RADIANCE),
              expected_of(n, -1, 2, 1));
        check("x turned",
              see_floor(texels[i], 1.0, ",\"scale\":[-1,1,1]", false, false, LK_RADIANCE),
              expected_of(n, -1, 2, 1));
        check("z turned",
              see_floor(texels[i], 1.0, ",\"scale\":[1,1,-1]", false, false, LK_RADIANCE),
              expected_of(n, 1, 2, -1));
    }
}

// From below, the relief is the same surface seen from behind.
static void backs_show_the_same_relief(void **state)
{
    (void)state;
    skip_without_device();
    for (int i = 0; i < 4; i++) {
        double n[3];
        tilt(n, texels[i], 1.0);
        check("back", see_floor(texels[i], 1.0, "", true, false, LK_RADIANCE),
              expected_of(n, -1, 2, -1));
    }
}

static void irradiance_is_measured_on_the_smooth_surface(void **state)
{
    (void)state;
    skip_without_device();
    check("E", see_floor(texels[3], 1.0, "", false, false, LK_IRRADIANCE), 2.0 / sqrt(6.0));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(red_tilts_along_u_and_green_against_v),
        cmocka_unit_test(mirrored_coordinates_and_instances_mirror_the_tilt),
        cmocka_unit_test(backs_show_the_same_relief),
        cmocka_unit_test(irradiance_is_measured_on_the_smooth_surface),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
