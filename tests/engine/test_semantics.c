// What DESIGN.md, section 3, promises of surfaces: sides, colours, quantities, normals.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "see.h"

#define PI       3.14159265358979323846
#define RADIANCE 5.0

static const float origin[3] = {0.0f, 0.0f, 0.0f};

// ---- Sides

static void surfaces_reflect_on_both_sides_alike(void **state)
{
    (void)state;
    skip_without_device();
    for (int glossy = 0; glossy < 2; glossy++) {
        double seen[2];
        for (int up = 0; up < 2; up++) {
            struct gltf_writer writer = {0};
            const int material =
                glossy ? gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"baseColorFactor\":"
                                                "[0.5,0.5,0.5,1],\"roughnessFactor\":0.4}}")
                       : gltf_lambert(&writer, 0.5);
            gltf_floor(&writer, material, 0.0f, 5.0f, up == 1);
            add_point_light(&writer, 0.4f, 2.0f, -0.3f);
            look_down(&writer, 0.0f, 0.0f);
            seen[up] = see_grey(&writer, 1);
        }
        assert_true(seen[0] > 0.0);
        assert_seen(seen[0], seen[1]);
    }
}

static double see_emitter(bool front, bool double_sided)
{
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_emitter(&writer, 0.0, RADIANCE, double_sided), 0.0f, 1.0f, front);
    look_down(&writer, 0.0f, 0.0f);
    return see_grey(&writer, 2);
}

static void surfaces_emit_behind_only_if_double_sided(void **state)
{
    (void)state;
    skip_without_device();
    assert_seen(see_emitter(true, false), RADIANCE);
    assert_true(see_emitter(false, false) == 0.0);
    assert_seen(see_emitter(true, true), RADIANCE);
    assert_seen(see_emitter(false, true), RADIANCE);
}

// A negative scale turns a mesh into its mirror image; its fronts stay fronts.
static double see_scaled_emitter(const char *scale)
{
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const float positions[] = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1}; // front up
    const struct gltf_mesh mesh = {
        .positions = positions, .triangles = triangles, .vertex_count = 4, .triangle_count = 2};
    struct gltf_writer writer = {0};
    const int index = gltf_mesh(&writer, gltf_emitter(&writer, 0.0, RADIANCE, false), &mesh);
    gltf_node(&writer, "{\"mesh\":%d,\"scale\":%s}", index, scale);
    look_down(&writer, 0.0f, 0.0f);
    return see_grey(&writer, 1);
}

static void negative_scale_mirrors_fronts(void **state)
{
    (void)state;
    skip_without_device();
    assert_seen(see_scaled_emitter("[1,1,1]"), RADIANCE);
    assert_seen(see_scaled_emitter("[-1,1,1]"), RADIANCE);
    assert_seen(see_scaled_emitter("[-1,1,-1]"), RADIANCE);
    assert_true(see_scaled_emitter("[1,-1,1]") == 0.0);
    assert_true(see_scaled_emitter("[-1,-1,-1]") == 0.0);
}

// ---- Colours and quantities

static void irradiance_leaves_out_the_first_surface(void **state)
{
    (void)state;
    skip_without_device();
    const double distance2 = 0.4 * 0.4 + 2.0 * 2.0 + 0.3 * 0.3;
    const double exact = 10.0 * 2.0 / (distance2 * sqrt(distance2));
    for (int i = 0; i < 3; i++) {
        struct gltf_writer writer = {0};
        const int material = i == 0   ? gltf_emitter(&writer, 0.0, 0.0, false)
                             : i == 1 ? gltf_emitter(&writer, 0.9, RADIANCE, true)
                                      : gltf_material(&writer, "{\"extensions\":"
                                                               "{\"KHR_materials_unlit\":{}}}");
        gltf_floor(&writer, material, 0.0f, 5.0f, true);
        add_point_light(&writer, 0.4f, 2.0f, -0.3f);
        look_down(&writer, 0.0f, 0.0f);
        struct lk_settings settings = test_settings(8, 8, 16);
        settings.quantity = LK_IRRADIANCE;
        settings.light_sampler = LK_LIGHTS_ALL;
        assert_seen(see_rgb(&writer, &settings).v[0], exact);
    }
}

static void unlit_shows_its_colour_and_nothing_else(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    const int unlit = gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"baseColorFactor\":"
                                             "[0.1,0.2,0.7,1]},\"extensions\":"
                                             "{\"KHR_materials_unlit\":{}}}");
    gltf_floor(&writer, unlit, 0.0f, 5.0f, true);
    add_point_light(&writer, 0.4f, 2.0f, -0.3f);
    look_down(&writer, 0.0f, 0.0f);
    const struct lk_settings settings = test_settings(8, 8, 4);
    const struct rgb seen = see_rgb(&writer, &settings);
    assert_seen(seen.v[0], 0.1);
    assert_seen(seen.v[1], 0.2);
    assert_seen(seen.v[2], 0.7);
}

// A square at y = 0, front up, with texture coordinates from (0, 0) at -x -z and vertex colours.
static void add_square(struct gltf_writer *writer, int material, const float *colors)
{
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const float positions[] = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1};
    static const float texcoords[] = {0, 1, 1, 1, 1, 0, 0, 0};
    const struct gltf_mesh mesh = {.positions = positions,
                                   .texcoords = texcoords,
                                   .colors = colors,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    gltf_node(writer, "{\"mesh\":%d}", gltf_mesh(writer, material, &mesh));
}

static void vertex_colours_multiply_the_base_colour(void **state)
{
    (void)state;
    skip_without_device();
    static const float colors[] = {1, 0, 0.25f, 1, 0, 0.25f, 0, 0.5f, 0.25f, 0, 0.5f, 0.25f};
    const float at[] = {-0.5f, 0.0f, 0.5f}; // z: from the first row to the second
    for (int i = 0; i < 3; i++) {
        struct gltf_writer writer = {0};
        const int material =
            gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.8,0.4,1]}"
                                   ",\"extensions\":{\"KHR_materials_unlit\":{}}}");
        add_square(&writer, material, colors);
        gltf_camera_flat(&writer, "down", (const float[]){0.2f, 1, at[i]},
                         (const float[]){0.2f, 0, at[i]}, 1e-4);
        const struct lk_settings settings = test_settings(4, 4, 4);
        const struct rgb seen = see_rgb(&writer, &settings);
        const double share = 0.5 * (1.0 + at[i]);
        assert_seen(seen.v[0], 0.8 * share);
        assert_seen(seen.v[1], 0.8 * 0.5 * (1.0 - share));
        assert_seen(seen.v[2], 0.4 * 0.25);
    }
}

static double srgb_to_linear(int byte)
{
    const double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : pow((x + 0.055) / 1.055, 2.4);
}

static void colour_textures_are_decoded_from_srgb_and_lie_as_gltf_says(void **state)
{
    (void)state;
    skip_without_device();
    static const uint8_t texels[] = {255, 10, 0, 255, 20, 128, 60,  255,  // far row: v = 0
                                     3,   40, 9, 255, 80, 200, 250, 255}; // near row
    for (int i = 0; i < 4; i++) {
        struct gltf_writer writer = {0};
        const int texture = gltf_texture(&writer, texels, 2, 2);
        const int material =
            gltf_material(&writer,
                          "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":%d}},"
                          "\"extensions\":{\"KHR_materials_unlit\":{}}}",
                          texture);
        const float x = i % 2 == 0 ? -0.4f : 0.4f;
        const float z = i < 2 ? -0.3f : 0.3f;
        add_square(&writer, material, NULL);
        gltf_camera_flat(&writer, "down", (const float[]){x, 1, z}, (const float[]){x, 0, z}, 1e-4);
        const struct lk_settings settings = test_settings(4, 4, 4);
        const struct rgb seen = see_rgb(&writer, &settings);
        for (int k = 0; k < 3; k++)
            assert_seen(seen.v[k], srgb_to_linear(texels[4 * i + k]));
    }
}

// ---- Interpolated normals

// A closed box whose corners' normals point along its diagonals, as on a sphere.
static void add_smooth_box(struct gltf_writer *writer, int material, float half)
{
    static const uint32_t walls[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                         {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    float positions[24], normals[24];
    uint32_t triangles[36];
    for (int i = 0; i < 24; i++) {
        const float sign = i / 3 >> (i % 3) & 1 ? 1.0f : -1.0f;
        positions[i] = sign * half;
        normals[i] = sign * sqrtf(1.0f / 3.0f);
    }
    for (int i = 0; i < 36; i++) {
        static const int fan[] = {0, 1, 2, 0, 2, 3};
        triangles[i] = walls[i / 6][fan[i % 6]];
    }
    const struct gltf_mesh mesh = {.positions = positions,
                                   .normals = normals,
                                   .triangles = triangles,
                                   .vertex_count = 8,
                                   .triangle_count = 12};
    gltf_node(writer, "{\"mesh\":%d}", gltf_mesh(writer, material, &mesh));
}

// What is seen of the box from within or outside, with all lights on the other side.
static double see_smooth_box(bool inside)
{
    struct gltf_writer writer = {0};
    const float away = inside ? 3.0f : 0.3f; // of the lights
    add_smooth_box(&writer, gltf_lambert(&writer, 0.9), 1.0f);
    gltf_floor(&writer, gltf_emitter(&writer, 0.5, RADIANCE, true), away, 0.5f, true);
    add_point_light(&writer, away, -away, 0.1f);
    gltf_light(&writer, (const float[]){-away, away, away}, origin,
               "{\"type\":\"spot\",\"intensity\":10,\"spot\":{}}");
    if (inside)
        gltf_light(&writer, (const float[]){1, 2, 3}, origin,
                   "{\"type\":\"directional\",\"intensity\":10}");
    gltf_camera(&writer, "eye", (const float[]){0.1f, 0.2f, inside ? 0.3f : 4.0f},
                (const float[]){0.1f, 0.1f, -1.0f}, inside ? 2.0 : 0.5);
    const struct lk_settings settings = test_settings(64, 64, 16);
    return see_mean(&writer, &settings);
}

static void interpolated_normals_let_no_light_through(void **state)
{
    (void)state;
    skip_without_device();
    assert_true(see_smooth_box(true) == 0.0);
    assert_true(see_smooth_box(false) == 0.0);
}

static void interpolated_normals_shade(void **state)
{
    (void)state;
    skip_without_device();
    static const uint32_t triangles[] = {0, 1, 2, 0, 2, 3};
    static const float positions[] = {-1, 0, 1, 1, 0, 1, 1, 0, -1, -1, 0, -1};
    const float s = sqrtf(0.5f);
    const float normals[] = {-s, s, 0, s, s, 0, s, s, 0, -s, s, 0}; // 45 degrees to either side
    const struct gltf_mesh mesh = {.positions = positions,
                                   .normals = normals,
                                   .triangles = triangles,
                                   .vertex_count = 4,
                                   .triangle_count = 2};
    const float x = 0.5f; // the normal there is (0.5 s, s, 0), made unit
    const double cosine = 1.0 / sqrt(1.25);
    struct gltf_writer writer = {0};
    const int material = gltf_lambert(&writer, 0.5);
    gltf_node(&writer, "{\"mesh\":%d}", gltf_mesh(&writer, material, &mesh));
    gltf_light(&writer, (const float[]){0, 1, 0}, origin,
               "{\"type\":\"directional\",\"intensity\":2}");
    gltf_camera_flat(&writer, "down", (const float[]){x, 1, 0}, (const float[]){x, 0, 0}, 1e-4);
    assert_seen(see_grey(&writer, 1), 2.0 * cosine * 0.5 / PI);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(surfaces_reflect_on_both_sides_alike),
        cmocka_unit_test(surfaces_emit_behind_only_if_double_sided),
        cmocka_unit_test(negative_scale_mirrors_fronts),
        cmocka_unit_test(irradiance_leaves_out_the_first_surface),
        cmocka_unit_test(unlit_shows_its_colour_and_nothing_else),
        cmocka_unit_test(vertex_colours_multiply_the_base_colour),
        cmocka_unit_test(colour_textures_are_decoded_from_srgb_and_lie_as_gltf_says),
        cmocka_unit_test(interpolated_normals_let_no_light_through),
        cmocka_unit_test(interpolated_normals_shade),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
