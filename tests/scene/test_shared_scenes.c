#include <ftw.h>
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include <cmocka.h>

#include "core/log.h"
#include "core/status.h"
#include "scene/gltf_import.h"

// Files that must not load, by a part of their path.
static const struct {
    const char *part;
    enum status status;
    const char *reason; // must stand in the message
} refusals[] = {
    {"features/Duck-Draco/", STATUS_UNSUPPORTED, "KHR_draco_mesh_compression"},
    {"features/AnisotropyBarnLamp/", STATUS_FORMAT, "no PNG, JPEG or WebP"}, // KTX2 textures only
    {"Negative/Mesh_PrimitiveRestart_09", STATUS_FORMAT, "restart"},
    {"Negative/Mesh_PrimitiveRestart_10", STATUS_FORMAT, "restart"},
    {"Negative/Mesh_PrimitiveRestart_12", STATUS_FORMAT, "restart"},
    {"Negative/Mesh_PrimitiveRestart_13", STATUS_FORMAT, "restart"},
    {"Compatibility_04", STATUS_UNSUPPORTED, "2.1"}, // its minVersion
};

static unsigned file_count;
static bool must_load;

// Every index within its bounds, every number finite, every normal of unit length, every tangent at
// a right angle to it.
static void check_mesh(const struct scene *scene, const struct scene_mesh *mesh)
{
    assert_true(mesh->material < scene->material_count);
    for (size_t i = 0; i < (size_t)mesh->triangle_count * 3; i++)
        assert_true(mesh->indices[i] < mesh->vertex_count);
    for (size_t v = 0; v < mesh->vertex_count; v++) {
        const float *p = mesh->positions + v * 3;
        const float *n = mesh->normals + v * 3;
        assert_true(isfinite(p[0]) && isfinite(p[1]) && isfinite(p[2]));
        // Float rounding leaves a unit vector within 1e-6 of length 1; 1e-3 tells it from others.
        assert_true(fabsf(n[0] * n[0] + n[1] * n[1] + n[2] * n[2] - 1.0f) < 1e-3f);
        if (mesh->tangents == NULL)
            continue;
        const float *t = mesh->tangents + v * 4;
        assert_true(fabsf(t[0] * t[0] + t[1] * t[1] + t[2] * t[2] - 1.0f) < 1e-3f);
        assert_true(fabsf(t[0] * n[0] + t[1] * n[1] + t[2] * n[2]) < 1e-3f);
        assert_true(t[3] == 1.0f || t[3] == -1.0f);
    }
}

static void check_scene(const struct scene *scene)
{
    assert_true(scene->material_count > 0);
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        check_mesh(scene, &scene->meshes[i]);
    for (uint32_t i = 0; i < scene->instance_count; i++)
        assert_true(scene->instances[i].mesh < scene->mesh_count);
    for (uint32_t i = 0; i < scene->texture_count; i++)
        assert_true(scene->textures[i].image >= 0 &&
                    (uint32_t)scene->textures[i].image < scene->image_count);
    for (uint32_t i = 0; i < scene->material_count; i++)
        assert_true(scene->materials[i].base_texture.texture < (int32_t)scene->texture_count);
}

static void check_refusal(const char *path, enum status status)
{
    for (size_t i = 0; i < sizeof(refusals) / sizeof(refusals[0]); i++) {
        if (strstr(path, refusals[i].part) == NULL)
            continue;
        assert_int_equal(status, refusals[i].status);
        assert_non_null(strstr(status_message(), refusals[i].reason));
        return;
    }
    if (must_load && status != STATUS_OK)
        fail_msg("%s", status_message());
}

static int visit(const char *path, const struct stat *info, int type, struct FTW *place)
{
    (void)info;
    (void)place;
    const char *dot = strrchr(path, '.');
    if (type != FTW_F || dot == NULL || (strcmp(dot, ".gltf") != 0 && strcmp(dot, ".glb") != 0))
        return 0;
    struct scene scene = {0};
    const enum status status = gltf_import(&scene, path);
    file_count++;
    if (status == STATUS_OK) {
        check_scene(&scene);
        scene_free(&scene);
    } else {
        assert_true(strncmp(status_message(), path, strlen(path)) == 0);
        assert_true(strlen(status_message()) > strlen(path) + 2);
    }
    check_refusal(path, status);
    return 0;
}

// Loads every file below a folder of the shared scenes; skips where there is none.
static void load_all(const char *name, bool all_load)
{
    const char *shared = getenv("LIGHTKILN_SHARED");
    char folder[512];
    struct stat info;
    snprintf(folder, sizeof(folder), "%s/scenes/%s", shared != NULL ? shared : "../shared", name);
    if (stat(folder, &info) != 0) {
        print_message("skipped: there is no folder %s\n", folder);
        skip();
    }
    file_count = 0;
    must_load = all_load;
    assert_int_equal(nftw(folder, visit, 16, FTW_PHYS), 0);
    assert_true(file_count > 0);
}

static void every_feature_file_loads_or_is_refused_for_its_reason(void **state)
{
    (void)state;
    load_all("features", true);
}

static void every_level_loads(void **state)
{
    (void)state;
    static const char *const levels[] = {"cornell",     "sibenik",      "sponza",
                                         "living_room", "steel_forest", "black_forest",
                                         "manylights",  "zdm2",         "units"};
    for (size_t i = 0; i < sizeof(levels) / sizeof(levels[0]); i++)
        load_all(levels[i], true);
}

static void malformed_files_load_or_say_why_not(void **state)
{
    (void)state;
    load_all("malformed", false);
}

static void ignore_message(void *user, enum log_level level, const char *message)
{
    (void)user;
    (void)level;
    (void)message;
}

int main(void)
{
    log_set_function(ignore_message, NULL);
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(every_feature_file_loads_or_is_refused_for_its_reason),
        cmocka_unit_test(every_level_loads),
        cmocka_unit_test(malformed_files_load_or_say_why_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
