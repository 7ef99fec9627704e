// Alpha masks: where a surface is cut out, no ray of any kind meets it, and no light leaves it.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include "see.h"

#define RADIANCE 5.0

static const float origin[3] = {0.0f, 0.0f, 0.0f};

// A masked sheet at y = 0.5 with this alpha, in black.
static void add_sheet(struct gltf_writer *writer, double alpha)
{
    const int material = gltf_material(writer,
                                       "{\"alphaMode\":\"MASK\",\"alphaCutoff\":0.5,"
                                       "\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,%g]},"
                                       "\"extensions\":{\"KHR_materials_specular\":"
                                       "{\"specularFactor\":0}}}",
                                       alpha);
    gltf_floor(writer, material, 0.5f, 5.0f, true);
}

static double see_through_sheet(double alpha, bool lamp)
{
    struct gltf_writer writer = {0};
    if (alpha >= 0.0)
        add_sheet(&writer, alpha);
    if (lamp) {
        gltf_floor(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), 0.0f, 1.0f, true);
        look_down(&writer, 0.0f, 0.0f);
    } else {
        gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 5.0f, true);
        add_point_light(&writer, 0.4f, 2.0f, -0.3f);
        gltf_camera_flat(&writer, "below", (const float[]){0, 0.25f, 0}, origin, 1e-4);
    }
    return see_grey(&writer, 1);
}

static void mask_lets_camera_rays_through(void **state)
{
    (void)state;
    skip_without_device();
    assert_seen(see_through_sheet(0.4, true), RADIANCE);
    assert_true(see_through_sheet(0.6, true) == 0.0);
}

static void mask_lets_shadow_rays_through(void **state)
{
    (void)state;
    skip_without_device();
    const double free_way = see_through_sheet(-1.0, false);
    assert_true(free_way > 0.0);
    assert_seen(see_through_sheet(0.4, false), free_way);
    assert_true(see_through_sheet(0.6, false) == 0.0);
}

// A mirror below a sheet below a lamp: what the camera sees has bounced through the sheet.
static double see_bounce(double alpha)
{
    struct gltf_writer writer = {0};
    const int mirror = gltf_material(
        &writer, "{\"extensions\":{\"KHR_materials_pbrSpecularGlossiness\":{\"diffuseFactor\":"
                 "[0,0,0,1],\"specularFactor\":[0.5,0.5,0.5],\"glossinessFactor\":1}}}");
    gltf_floor(&writer, mirror, 0.0f, 1.0f, true);
    add_sheet(&writer, alpha);
    gltf_floor(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), 3.0f, 1.0f, false);
    gltf_camera_flat(&writer, "below", (const float[]){0, 0.25f, 0}, origin, 1e-4);
    struct lk_settings settings = test_settings(4, 4, 4);
    settings.brdf = LK_BRDF_PHONG;
    return see_rgb(&writer, &settings).v[0];
}

static void mask_lets_bounces_through(void **state)
{
    (void)state;
    skip_without_device();
    assert_seen(see_bounce(0.4), 0.5 * RADIANCE);
    assert_true(see_bounce(0.6) == 0.0);
}

// A quad whose texture has a column of full and one of no alpha.
static void add_half_lamp(struct gltf_writer *writer)
{
    static const uint8_t texels[] = {255, 255, 255, 255, 255, 255, 255, 0};
    static const float positions[] = {-1, 2, -1, 1, 2, -1, 1, 2, 1, -1, 2, 1}; // front down
    static const float texcoords[] = {0, 0, 1, 0, 1, 1, 0, 1};
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    const struct gltf_mesh mesh = {.positions = positions,
                                   .texcoords = texcoords,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    const int texture = gltf_texture(writer, texels, 2, 1);
    const int material =
        gltf_material(writer,
                      "{\"alphaMode\":\"MASK\",\"emissiveFactor\":[1,1,1],"
                      "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%d}}}",
                      texture);
    gltf_node(writer, "{\"mesh\":%d}", gltf_mesh(writer, material, &mesh));
}

// Irradiance below half a lamp, with a mask or as a quad of its own.
static struct estimate see_half_lamp(bool masked)
{
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 5.0f, true);
    if (masked)
        add_half_lamp(&writer);
    else
        gltf_quad(&writer, gltf_emitter(&writer, 0.0, 1.0, false),
                  (const float[]){-1, 2, -1, 0, 2, -1, 0, 2, 1, -1, 2, 1});
    gltf_camera_flat(&writer, "aside", (const float[]){0.5f, 1, 0}, (const float[]){0.5f, 0, 0},
                     1e-4);
    struct lk_settings settings = test_settings(32, 32, 256);
    settings.quantity = LK_IRRADIANCE;
    settings.depth = 1;
    return see_point(&writer, &settings);
}

static void masked_lamp_shines_where_it_is_solid(void **state)
{
    (void)state;
    skip_without_device();
    assert_same_mean("half a lamp", see_half_lamp(true), see_half_lamp(false));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(mask_lets_camera_rays_through),
        cmocka_unit_test(mask_lets_shadow_rays_through),
        cmocka_unit_test(mask_lets_bounces_through),
        cmocka_unit_test(masked_lamp_shines_where_it_is_solid),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
