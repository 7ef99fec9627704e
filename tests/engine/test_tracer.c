// Rays of the caller's on a device: what they hit, and what is refused.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <float.h>
#include <math.h>
#include <string.h>

#include "gltf_writer.h"
#include "render_support.h"

#define EPSILON 1e-4f
#define SIZE    16u // pixels on a side

static const float eye[3] = {0.0f, 3.0f, 0.0f};

// A floor 4 m wide at y = 0 that nothing hides, below a point light and a sun.
static struct lk_scene *load_floor(void)
{
    struct gltf_writer writer = {0};
    gltf_floor(&writer, gltf_lambert(&writer, 0.5), 0.0f, 2.0f, true);
    gltf_camera(&writer, "down", eye, (const float[]){0.01f, 0.0f, 0.0f}, 0.5);
    gltf_light(&writer, eye, (const float[]){0, 0, 0}, "{\"type\":\"point\",\"intensity\":2}");
    gltf_light(&writer, eye, (const float[]){0, 0, 0}, "{\"type\":\"directional\"}");
    return gltf_load(&writer);
}

static struct lk_tracer *create(struct lk_scene *scene)
{
    const struct lk_settings settings = test_settings(SIZE, SIZE, 1);
    struct lk_tracer *tracer = NULL;
    if (lk_tracer_create(&tracer, scene, &settings) != LK_OK)
        fail_msg("%s", lk_error());
    return tracer;
}

static void camera_rays_meet_the_floor_below(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = load_floor();
    struct lk_tracer *tracer = create(scene);
    struct lk_ray rays[SIZE * SIZE];
    struct lk_hit hits[SIZE * SIZE];
    assert_int_equal(lk_tracer_camera_rays(tracer, rays), LK_OK);
    for (int any_hit = 0; any_hit < 2; any_hit++) {
        assert_int_equal(lk_tracer_set_rays(tracer, rays, SIZE * SIZE), LK_OK);
        assert_int_equal(lk_tracer_run(tracer, NULL, any_hit, 3), LK_OK);
        assert_int_equal(lk_tracer_hits(tracer, hits), LK_OK);
        for (uint32_t i = 0; i < SIZE * SIZE; i++) {
            const float t = -rays[i].org[1] / rays[i].dir[1];
            assert_memory_equal(rays[i].org, eye, sizeof(eye));
            assert_true(hits[i].triangle < (any_hit ? 1 : 2));
            assert_true(any_hit || fabsf(hits[i].t - t) <= EPSILON * t);
        }
    }
    lk_tracer_free(tracer);
    lk_scene_free(scene);
}

static void rays_end_where_they_should(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = load_floor();
    struct lk_tracer *tracer = create(scene);
    const struct lk_ray rays[] = {
        {{0.3f, 2, 0.5f}, 0.0f, {0, -1, 0}, FLT_MAX}, // down
        {{0.3f, 2, 0.5f}, 0.0f, {0, 1, 0}, FLT_MAX},  // up
        {{0.3f, 2, 0.5f}, 0.0f, {0, -1, 0}, 1.9f},    // down, not far enough
        {{0.3f, 2, 0.5f}, 2.1f, {0, -1, 0}, FLT_MAX}, // from beyond
        {{5.0f, 2, 0.5f}, 0.0f, {0, -1, 0}, FLT_MAX}, // beside
    };
    struct lk_hit hits[5];
    assert_int_equal(lk_tracer_set_rays(tracer, rays, 5), LK_OK);
    assert_int_equal(lk_tracer_run(tracer, NULL, false, 1), LK_OK);
    assert_int_equal(lk_tracer_hits(tracer, hits), LK_OK);
    assert_true(hits[0].triangle < 2 && fabsf(hits[0].t - 2.0f) < EPSILON);
    for (int i = 1; i < 5; i++)
        assert_true(hits[i].triangle == LK_HIT_NONE);
    lk_tracer_free(tracer);
    lk_scene_free(scene);
}

static void too_many_rays_or_launches_are_refused(void **state)
{
    (void)state;
    skip_without_device();
    struct lk_scene *scene = load_floor();
    struct lk_tracer *tracer = create(scene);
    static const struct lk_ray rays[SIZE * SIZE + 1];
    assert_int_equal(lk_tracer_set_rays(tracer, rays, SIZE * SIZE + 1), LK_USAGE);
    assert_int_equal(lk_tracer_run(tracer, NULL, false, 0), LK_USAGE);
    assert_int_equal(lk_tracer_run(tracer, NULL, false, LK_LAUNCHES_MAX + 1), LK_USAGE);
    lk_tracer_free(tracer);
    lk_scene_free(scene);
}

static void geometry_and_lights_are_in_world_space(void **state)
{
    (void)state;
    struct lk_scene *scene = load_floor();
    struct lk_geometry geometry;
    float place[4];
    assert_false(lk_scene_light(place, scene, 0));
    assert_int_equal(lk_scene_geometry(&geometry, scene), LK_OK);
    assert_int_equal(geometry.triangle_count, 2);
    for (uint64_t i = 0; i < geometry.vertex_count; i++) {
        const float *p = geometry.positions + i * geometry.position_stride;
        assert_true(fabsf(p[0]) == 2.0f && p[1] == 0.0f && fabsf(p[2]) == 2.0f);
    }
    for (uint64_t i = 0; i < geometry.triangle_count; i++)
        for (int k = 0; k < 3; k++)
            assert_true(geometry.corners[i * geometry.corner_stride + (uint64_t)k] <
                        geometry.vertex_count);
    assert_true(lk_scene_light(place, scene, 0));
    assert_memory_equal(place, eye, sizeof(eye));
    assert_true(place[3] == 1.0f);
    assert_true(lk_scene_light(place, scene, 1));
    assert_true(fabsf(place[1] - 1.0f) < EPSILON && place[3] == 0.0f);
    assert_false(lk_scene_light(place, scene, 2));
    lk_scene_free(scene);
}

// The floor is one node; a ray that misses its boxes tests no triangle, others some of the two.
static void visits_are_those_of_the_floor(void **state)
{
    (void)state;
    struct lk_scene *scene = load_floor();
    const struct lk_settings settings = test_settings(SIZE, SIZE, 1);
    const struct lk_ray rays[] = {
        {{0.3f, 2, 0.5f}, 0.0f, {0, -1, 0}, FLT_MAX}, // down
        {{0.3f, 2, 0.5f}, 0.0f, {0, 1, 0}, FLT_MAX},  // up
        {{0.3f, 2, 0.5f}, 0.0f, {0, -1, 0}, FLT_MAX}, // down
        {{5.0f, 2, 0.5f}, 0.0f, {0, -1, 0}, FLT_MAX}, // beside
    };
    for (int any_hit = 0; any_hit < 2; any_hit++) {
        struct lk_visits all, missing, none;
        assert_int_equal(lk_scene_visits(&all, scene, &settings, rays, 4, 1, any_hit), LK_OK);
        assert_int_equal(lk_scene_visits(&missing, scene, &settings, rays + 1, 3, 2, any_hit),
                         LK_OK);
        assert_int_equal(lk_scene_visits(&none, scene, &settings, rays, 0, 1, any_hit), LK_OK);
        assert_true(all.nodes == 1.0);
        assert_true(all.triangles >= 0.5 && all.triangles <= 1.0);
        assert_true(missing.nodes == 1.0 && missing.triangles == 0.0);
        assert_true(none.nodes == 0.0 && none.triangles == 0.0);
    }
    struct lk_visits visits;
    assert_int_equal(lk_scene_visits(&visits, scene, &settings, rays, 4, 0, false), LK_USAGE);
    assert_non_null(strstr(lk_error(), "step"));
    lk_scene_free(scene);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(camera_rays_meet_the_floor_below),
        cmocka_unit_test(rays_end_where_they_should),
        cmocka_unit_test(too_many_rays_or_launches_are_refused),
        cmocka_unit_test(visits_are_those_of_the_floor),
        cmocka_unit_test(geometry_and_lights_are_in_world_space),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
