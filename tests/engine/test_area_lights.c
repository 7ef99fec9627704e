// Rectangles and discs of EXT_lights_area against closed forms of what a plane receives.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>

#include "form_factor.h"
#include "see.h"

#define PI        3.14159265358979323846
#define HEIGHT    2.0f // of the lights over the plane, m
#define NITS      5.0
#define TOLERANCE 3e-4 // relative: as in test_closed_forms.c

static const float above[3] = {0.0f, HEIGHT, 0.0f};
static const float origin[3] = {0.0f, 0.0f, 0.0f};

// A plane at y = 0 seen at (x, 0, 0).
static void add_plane(struct gltf_writer *writer, float x)
{
    gltf_floor(writer, gltf_lambert(writer, 0.6), 0.0f, 50.0f, true);
    look_down(writer, x, 0.0f);
}

static struct estimate see(struct gltf_writer *writer, enum lk_light_sampler sampler)
{
    struct lk_settings settings = test_settings(16, 16, 1024);
    settings.depth = 1;
    settings.quantity = LK_IRRADIANCE;
    settings.light_sampler = sampler;
    return see_point(writer, &settings);
}

// On the axis of a disc of radius r at distance d: E = pi L r^2 / (r^2 + d^2).
static void disc_overhead_gives_its_form_factor(void **state)
{
    (void)state;
    skip_without_device();
    for (int sampler = LK_LIGHTS_TREE; sampler <= LK_LIGHTS_IMPORTANCE; sampler++) {
        struct gltf_writer writer = {0};
        const double radius = 0.75;
        add_plane(&writer, 0.0f);
        gltf_area_light(&writer, above, origin, "{\"type\":\"disk\",\"size\":1.5,\"intensity\":%g}",
                        NITS);
        const double exact = PI * NITS * radius * radius / (radius * radius + HEIGHT * HEIGHT);
        assert_agrees("disc", see(&writer, (enum lk_light_sampler)sampler), exact, TOLERANCE);
    }
}

// The rectangle's middle is overhead: four quarters.
static void rectangle_overhead_gives_its_form_factor(void **state)
{
    (void)state;
    skip_without_device();
    for (int sampler = LK_LIGHTS_TREE; sampler <= LK_LIGHTS_IMPORTANCE; sampler++) {
        struct gltf_writer writer = {0};
        add_plane(&writer, 0.0f);
        gltf_area_light(&writer, above, origin,
                        "{\"type\":\"rect\",\"size\":1,\"rect\":{\"aspect\":3},\"intensity\":%g,"
                        "\"color\":[1,1,1]}",
                        NITS);
        const double exact = NITS * PI * 4.0 * form_factor_parallel(1.5, 0.5, HEIGHT);
        assert_agrees("rectangle", see(&writer, (enum lk_light_sampler)sampler), exact, TOLERANCE);
    }
}

// A node's scale, its largest, makes the light larger, never brighter.
static void the_largest_scale_of_the_node_sizes_the_light(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    add_plane(&writer, 0.0f);
    gltf_area_light(&writer, (const float[]){0, -5, 0}, (const float[]){0, -9, 0},
                    "{\"type\":\"disk\",\"intensity\":%g}", NITS); // shines downwards, below
    gltf_node(&writer,
              "{\"translation\":[0,%g,0],\"rotation\":[-0.70710678,0,0,0.70710678],"
              "\"scale\":[0.5,-3,1],\"extensions\":{\"EXT_lights_area\":{\"light\":0}}}",
              (double)HEIGHT);
    const double exact = PI * NITS * 2.25 / (2.25 + HEIGHT * HEIGHT);
    assert_agrees("scaled", see(&writer, LK_LIGHTS_TREE), exact, TOLERANCE);
}

static void area_lights_shine_to_one_side_and_are_not_seen(void **state)
{
    (void)state;
    skip_without_device();
    struct gltf_writer writer = {0};
    add_plane(&writer, 0.0f);
    gltf_area_light(&writer, above, (const float[]){0, 9, 0},
                    "{\"type\":\"rect\",\"size\":2,\"intensity\":%g}", NITS);
    assert_true(see(&writer, LK_LIGHTS_TREE).mean == 0.0);

    add_plane(&writer, 0.0f);
    gltf_camera_flat(&writer, "up", origin, above, 0.1);
    gltf_area_light(&writer, above, origin, "{\"type\":\"rect\",\"size\":2,\"intensity\":%g}",
                    NITS);
    struct lk_scene *scene = gltf_load(&writer);
    struct lk_settings settings = test_settings(8, 8, 4);
    settings.camera = "up";
    assert_true(render_mean(scene, &settings) == 0.0);

    struct lk_scene_info info;
    assert_int_equal(lk_scene_info(&info, scene, &settings), LK_OK);
    assert_int_equal(info.lights.rect, 1);
    lk_scene_free(scene);
}

// A glossy surface cannot find the light by bounces: light samples count in full.
static void glossy_surfaces_get_all_of_an_area_light(void **state)
{
    (void)state;
    skip_without_device();
    struct estimate seen[2];
    for (int way = 0; way < 2; way++) {
        struct gltf_writer writer = {0};
        const int glossy = gltf_material(
            &writer, "{\"pbrMetallicRoughness\":{\"metallicFactor\":1,\"roughnessFactor\":0.5}}");
        gltf_floor(&writer, glossy, 0.0f, 4.0f, true);
        gltf_camera_flat(&writer, "down", (const float[]){1, 1, 0.2f}, origin, 0.3);
        if (way == 0)
            gltf_area_light(&writer, above, origin,
                            "{\"type\":\"rect\",\"size\":2,\"intensity\":%g}", NITS);
        else
            gltf_floor(&writer, gltf_emitter(&writer, 0.0, NITS, false), HEIGHT, 1.0f, false);
        struct lk_scene *scene = gltf_load(&writer);
        struct lk_settings settings = test_settings(32, 32, 64);
        settings.depth = 3;
        seen[way] = estimate_image(scene, &settings, 16);
        lk_scene_free(scene);
    }
    assert_same_mean("light and surface", seen[0], seen[1]);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(disc_overhead_gives_its_form_factor),
        cmocka_unit_test(rectangle_overhead_gives_its_form_factor),
        cmocka_unit_test(the_largest_scale_of_the_node_sizes_the_light),
        cmocka_unit_test(area_lights_shine_to_one_side_and_are_not_seen),
        cmocka_unit_test(glossy_surfaces_get_all_of_an_area_light),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
