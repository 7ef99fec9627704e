#include "see.h"

#include <stdarg.h>
#include <stddef.h>
#include <setjmp.h>
#include <cmocka.h>

#define TOLERANCE 2e-4 // relative

void look_down(struct gltf_writer *writer, float x, float z)
{
    gltf_camera_flat(writer, "down", (const float[]){x, 1, z}, (const float[]){x, 0, z}, SPECK);
}

void add_point_light(struct gltf_writer *writer, float x, float y, float z)
{
    gltf_light(writer, (const float[]){x, y, z}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":10}");
}

struct rgb see_rgb(struct gltf_writer *writer, const struct lk_settings *settings)
{
    struct lk_scene *scene = gltf_load(writer);
    const struct rgb seen = render_rgb(scene, settings);
    lk_scene_free(scene);
    return seen;
}

double see_mean(struct gltf_writer *writer, const struct lk_settings *settings)
{
    struct lk_scene *scene = gltf_load(writer);
    const double seen = render_mean(scene, settings);
    lk_scene_free(scene);
    return seen;
}

struct estimate see_point(struct gltf_writer *writer, const struct lk_settings *settings)
{
    struct lk_scene *scene = gltf_load(writer);
    const struct estimate seen = estimate_point(scene, settings);
    lk_scene_free(scene);
    return seen;
}

double see_grey(struct gltf_writer *writer, uint32_t depth)
{
    struct lk_settings settings = test_settings(8, 8, 4);
    settings.depth = depth;
    const struct rgb seen = see_rgb(writer, &settings);
    assert_true(seen.v[0] == seen.v[1] && seen.v[1] == seen.v[2]);
    return seen.v[0];
}

void assert_seen(double seen, double exact)
{
    assert_agrees("seen", (struct estimate){seen, 0.0}, exact, TOLERANCE);
}
