// The report holds every promised name, and reads as JSON should.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <string.h>

#include "core/choices.h"
#include "lightkiln/image.h"
#include "output/report.h"

static struct lk_render_info make_info(void)
{
    struct lk_render_info info = {0};
    info.scene.file = "a \"level\".glb";
    info.scene.triangles = 12;
    info.settings = (struct lk_settings){.width = 4, .height = 2, .spp = 8, .depth = 5};
    info.device_count = 2;
    strcpy(info.devices[0].info.name, "a device");
    strcpy(info.devices[1].info.name, "another");
    info.devices[0].paths = 6;
    info.devices[1].paths = 4;
    info.time_s.render = 2.0;
    info.time_s.total = 3.0;
    info.rays_camera = 10;
    info.rays_indirect = 20;
    info.rays_shadow = 30;
    info.paths = 10;
    info.spp = 8.0;
    return info;
}

static void assert_has(const struct json *json, const char *text)
{
    if (strstr(json->text, text) == NULL)
        fail_msg("no %s in\n%s", text, json->text);
}

static void report_has_every_promised_name(void **state)
{
    (void)state;
    static const char *const names[] = {"version",
                                        "scene",
                                        "file",
                                        "triangles",
                                        "triangles_split",
                                        "instances",
                                        "materials",
                                        "textures",
                                        "lights",
                                        "point",
                                        "spot",
                                        "rect",
                                        "directional",
                                        "emissive_triangles",
                                        "settings",
                                        "device",
                                        "platform",
                                        "name",
                                        "driver",
                                        "type",
                                        "compute_units",
                                        "memory_bytes",
                                        "bvh",
                                        "geometry",
                                        "rays",
                                        "film",
                                        "total_device",
                                        "peak_host",
                                        "time_s",
                                        "import",
                                        "prepare",
                                        "upload",
                                        "kernel_build",
                                        "render",
                                        "write",
                                        "total",
                                        "kernels",
                                        "calls",
                                        "share",
                                        "camera",
                                        "indirect",
                                        "shadow",
                                        "directional",
                                        "bytes_per_s",
                                        "paths",
                                        "spp",
                                        "rays_per_s",
                                        "paths_per_s",
                                        "noise",
                                        "width",
                                        "height",
                                        "time",
                                        "depth",
                                        "roulette_depth",
                                        "shadow_rays",
                                        "light_sampler",
                                        "sampler",
                                        "quantity",
                                        "brdf",
                                        "trace",
                                        "nodes",
                                        "split_threshold",
                                        "leaf_size",
                                        "seed",
                                        "queue",
                                        "busy_s",
                                        "memory_limit",
                                        "profile"};
    struct lk_render_info info = make_info();
    info.kernel_count = 1;
    strcpy(info.kernels[0].name, "trace");
    info.kernels[0].rays = 1;
    info.kernels[0].bytes = 1;
    info.kernels[0].time_s = 1.0;

    struct json json = {0};
    assert_int_equal(report_write(&json, &info, "1", 0.0), STATUS_OK);
    for (size_t i = 0; i < sizeof(names) / sizeof(names[0]); i++) {
        char quoted[64];
        snprintf(quoted, sizeof(quoted), "\"%s\": ", names[i]);
        assert_has(&json, quoted);
    }
    json_free(&json);
}

static void report_adds_up(void **state)
{
    (void)state;
    struct lk_render_info info = make_info();
    info.kernel_count = 2;
    info.kernels[0].time_s = 3.0;
    info.kernels[1].time_s = 1.0;

    struct json json = {0};
    assert_int_equal(report_write(&json, &info, "1", 0.5), STATUS_OK);
    assert_has(&json, "\"total\": 60"); // rays
    assert_has(&json, "\"rays_per_s\": 30");
    assert_has(&json, "\"paths_per_s\": 5");
    assert_has(&json, "\"write\": 0.5,\n    \"total\": 3.5");
    assert_has(&json, "\"share\": 0.75");
    assert_has(&json, "\"file\": \"a \\\"level\\\".glb\"");
    json_free(&json);
}

static void kernels_are_told_with_a_profile_only(void **state)
{
    (void)state;
    const struct lk_render_info info = make_info();
    struct json json = {0};
    assert_int_equal(report_write(&json, &info, "1", 0.0), STATUS_OK);
    assert_null(strstr(json.text, "\"kernels\""));
    json_free(&json);
}

static void picture_settings_leave_out_what_must_not_matter(void **state)
{
    (void)state;
    struct lk_render_info info = make_info();
    struct json first = {.compact = true};
    report_picture_settings(&first, NULL, &info.settings);
    assert_int_equal(json_finish(&first), STATUS_OK);

    info.settings.queue = 4096;
    info.settings.memory_limit = 1000000;
    info.settings.profile = true;
    info.settings.no_cache = true;
    struct json second = {.compact = true};
    report_picture_settings(&second, NULL, &info.settings);
    assert_int_equal(json_finish(&second), STATUS_OK);
    assert_string_equal(first.text, second.text);

    json_free(&first);
    json_free(&second);
}

static int count(const char *const *words)
{
    int n = 0;
    while (words[n] != NULL)
        n++;
    return n;
}

static void every_choice_has_a_word(void **state)
{
    (void)state;
    assert_int_equal(count(choices_quantity), LK_DIRECT + 1);
    assert_int_equal(count(choices_brdf), LK_BRDF_PHONG + 1);
    assert_int_equal(count(choices_light_sampler), LK_LIGHTS_IMPORTANCE + 1);
    assert_int_equal(count(choices_sampler), LK_SAMPLER_RANDOM + 1);
    assert_int_equal(count(choices_trace), LK_TRACE_WARPS + 1);
    assert_int_equal(count(choices_bvh), LK_BVH_COMPRESSED + 1);
    assert_int_equal(count(choices_bvh_build), LK_BVH_BUILD_THESIS + 1);
    assert_int_equal(count(choices_textures), LK_TEXTURES_POOL + 1);
    assert_int_equal(count(choices_nodes), LK_NODES_TEXTURE + 1);
    assert_int_equal(count(choices_tonemap), LK_TONEMAP_ACES + 1);
    assert_int_equal(count(choices_log_level), LK_LOG_DEBUG + 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(report_has_every_promised_name),
        cmocka_unit_test(report_adds_up),
        cmocka_unit_test(kernels_are_told_with_a_profile_only),
        cmocka_unit_test(picture_settings_leave_out_what_must_not_matter),
        cmocka_unit_test(every_choice_has_a_word),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
