/**
 * @file
 * What tests of choosing a form of tracing share: a scene, a cache of their own, and candidates of
 * their own, so that CPUs, too, have something to choose.
 */
#ifndef TESTS_ENGINE_PROBE_FIXTURE_H
#define TESTS_ENGINE_PROBE_FIXTURE_H

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "choice.h"
#include "folder.h"
#include "gltf_writer.h"
#include "probe.h"
#include "render_support.h"

#define PATH_SIZE 1024
#define BOTH      (FORM_TRACES | FORM_SHADOWS)

static const struct form sound[] = {
    {LK_TRACE_SIMPLE, LK_BVH_BINARY, BOTH, NULL},
    {LK_TRACE_PERSISTENT, LK_BVH_BINARY, BOTH, NULL},
    {LK_TRACE_SIMPLE, LK_BVH_QUAD, BOTH, NULL},
    {LK_TRACE_PERSISTENT, LK_BVH_QUAD, BOTH, NULL},
};

static struct lk_scene *scene; // of the group

/** A room with a lamp and something in it, and a mirror for bounces; and a cache of its own. */
static inline int make_scene(void **state)
{
    struct gltf_writer writer = {0};
    gltf_room(&writer, gltf_lambert(&writer, 0.7), (const float[]){-2, -1, -2},
              (const float[]){2, 2, 3});
    gltf_floor(&writer, gltf_emitter(&writer, 0.2, 3.0, false), 1.9f, 0.6f, false);
    const int mirror = gltf_material(&writer, "{\"pbrMetallicRoughness\":{\"metallicFactor\":1,"
                                              "\"roughnessFactor\":0.1}}");
    for (int i = 0; i < 40; i++) {
        const float x = -1.5f + 0.07f * (float)i;
        const float y = 0.01f * (float)(i * i % 17);
        gltf_triangle(&writer, mirror, (const float[]){x, y, 0, x + 0.2f, y, 0.3f, x, 0.4f, 0.1f});
    }
    gltf_light(&writer, (const float[]){1, 1, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"point\",\"intensity\":2}");
    gltf_light(&writer, (const float[]){1, 2, 1}, (const float[]){0, 0, 0},
               "{\"type\":\"directional\",\"intensity\":1}");
    gltf_camera(&writer, "front", (const float[]){0.1f, 0.3f, 2.9f}, (const float[]){0, 0.2f, 0},
                1.1);
    scene = gltf_load(&writer);
    return folder_setup_cache(state);
}

static inline int free_scene(void **state)
{
    lk_scene_free(scene);
    return folder_teardown(state);
}

/** Every test starts with an empty cache, with sound candidates and time enough for a slow machine.
 */
static inline int begin(void **state)
{
    (void)state;
    folder_empty();
    choice_forget();
    choice_candidates = sound;
    choice_candidate_count = sizeof(sound) / sizeof(sound[0]);
    probe_limits = (struct probe_limits){.all = INFINITY, .launch = 120.0, .grace = 1.0};
    return 0;
}

/** Counts the notes in the cache; path [PATH_SIZE]: of one of them, if there is any. */
static inline unsigned find_notes(char *path)
{
    unsigned count = 0;
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    for (struct dirent *entry = readdir(dir); entry != NULL; entry = readdir(dir)) {
        const char *dot = strrchr(entry->d_name, '.');
        if (dot == NULL || strcmp(dot, ".txt") != 0)
            continue;
        snprintf(path, PATH_SIZE, "%s/%s", folder, entry->d_name);
        count++;
    }
    closedir(dir);
    return count;
}

static inline struct lk_settings settings_of(enum lk_trace trace, enum lk_bvh bvh)
{
    struct lk_settings settings = test_settings(96, 64, 2);
    settings.depth = 4;
    settings.trace = trace;
    settings.bvh = bvh;
    return settings;
}

static inline struct lk_settings open_settings(void)
{
    return settings_of(LK_TRACE_AUTO, LK_BVH_AUTO);
}

static inline const struct lk_device_share *share_of(const struct lk_image *image)
{
    return &lk_image_info(image)->devices[0];
}

/** Renders, and asserts that all rays are traced as they are for one reason. */
static inline struct lk_image *render_for(const struct lk_settings *settings, enum lk_reason reason)
{
    struct lk_image *image = render(scene, settings);
    const struct lk_device_share *share = share_of(image);
    for (int i = 0; i < LK_RAYS_COUNT; i++)
        assert_int_equal(share->tracing[i].reason, reason);
    assert_true((share->probe_s > 0.0) == (reason == LK_REASON_PROBE));
    return image;
}

/** Where compilers round alike, bits are equal; elsewhere few paths may go another way. */
static inline void assert_same_picture(const struct lk_image *a, const struct lk_image *b)
{
    struct lk_comparison comparison;
    assert_int_equal(lk_compare(&comparison, NULL, a, b), LK_OK);
    if (strcmp(share_of(a)->info.type, "cpu") == 0)
        assert_true(comparison.maximum == 0.0);
    for (int i = 0; i < 3; i++)
        assert_true(comparison.mean[i] > 0.01 && comparison.rmse < 0.05 * comparison.mean[i]);
}

#endif
