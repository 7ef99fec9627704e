#include <stdio.h>

#include "cli/bench.h"
#include "cli/progress.h"
#include "core/json.h"

#define DEFAULT_TIME_S  10.0 // of each sampler
#define REFERENCE_TIMES 10   // a rendered reference takes so many times as long

// One sampler's result.
struct lights_row {
    const char *name;
    enum lk_light_sampler sampler;
    struct lk_comparison comparison;
    struct lk_render_info info;
};

// Renders with one sampler for some seconds.
static enum status render_timed(struct lk_image **out, struct lk_scene *scene,
                                const struct lk_settings *settings, enum lk_light_sampler sampler,
                                double seconds, uint32_t seed, const struct options *options)
{
    struct lk_settings timed = *settings;
    struct progress progress;
    progress_init(&progress, options->quiet, false);
    const struct lk_progress_hook hook = {progress_report, &progress};
    timed.light_sampler = sampler;
    timed.spp = 0;
    timed.time_s = seconds;
    timed.seed = seed;
    const enum status status = (enum status)lk_render(out, scene, &timed, &hook);
    progress_end(&progress);
    return status;
}

// Reads the reference, or renders one with the sampler that is best where it matters; its seed is
// its own, so that its noise is nobody's.
static enum status make_reference(struct lk_image **out, struct lk_scene *scene,
                                  const struct lk_settings *settings, const struct options *options)
{
    if (options->reference != NULL)
        return (enum status)lk_image_read(out, options->reference);
    const double seconds = options->reference_time_s > 0.0 ? options->reference_time_s
                                                           : REFERENCE_TIMES * settings->time_s;
    return render_timed(out, scene, settings, LK_LIGHTS_IMPORTANCE, seconds, settings->seed + 1,
                        options);
}

static uint64_t light_count(const struct lk_lights *lights)
{
    return lights->point + lights->spot + lights->rect + lights->emissive_triangles;
}

static void print_rows(const struct lights_row *rows, size_t count, const struct options *options)
{
    const struct lk_render_info *info = &rows[0].info;
    printf("%s, %u x %u, depth %u, %g s each, %llu lights, %s\n", options->operands[1],
           info->settings.width, info->settings.height, info->settings.depth, info->settings.time_s,
           (unsigned long long)light_count(&info->scene.lights), info->device.name);
    printf("%-12s %9s %12s %12s %12s %12s %14s\n", "sampler", "spp", "variance", "of uniform",
           "Mrays/s", "ns/shadow", "bytes/light");
    for (size_t i = 0; i < count; i++) {
        const struct lk_render_info *row = &rows[i].info;
        const double rays = (double)(row->rays_camera + row->rays_indirect + row->rays_shadow);
        const uint64_t lights = light_count(&row->scene.lights);
        printf("%-12s %9.1f %12.5g %12.4f %12.2f %12.1f %14.1f\n", rows[i].name, row->spp,
               rows[i].comparison.variance,
               rows[i].comparison.variance / rows[0].comparison.variance,
               rays / row->time_s.render * 1e-6,
               row->time_s.render * 1e9 / (double)(row->rays_shadow > 0 ? row->rays_shadow : 1),
               lights > 0 ? (double)row->scene.memory.lights / (double)lights : 0.0);
    }
}

static enum status print_json(const struct lights_row *rows, size_t count,
                              const struct options *options)
{
    struct json json = {0};
    json_object(&json, NULL);
    json_string(&json, "scene", options->operands[1]);
    json_string(&json, "device", rows[0].info.device.name);
    json_double(&json, "time_s", rows[0].info.settings.time_s);
    json_uint(&json, "depth", rows[0].info.settings.depth);
    json_uint(&json, "lights", light_count(&rows[0].info.scene.lights));
    json_array(&json, "samplers");
    for (size_t i = 0; i < count; i++) {
        json_object(&json, NULL);
        json_string(&json, "name", rows[i].name);
        json_double(&json, "variance", rows[i].comparison.variance);
        json_double(&json, "spp", rows[i].info.spp);
        json_double(&json, "render_s", rows[i].info.time_s.render);
        json_uint(&json, "rays_shadow", rows[i].info.rays_shadow);
        json_uint(&json, "lights_bytes", rows[i].info.scene.memory.lights);
        json_object_end(&json);
    }
    json_array_end(&json);
    json_object_end(&json);
    const enum status status = json_finish(&json);
    if (status == STATUS_OK)
        fputs(json.text, stdout);
    json_free(&json);
    return status;
}

enum status bench_lights(const struct options *options)
{
    struct lights_row rows[] = {
        {.name = "uniform", .sampler = LK_LIGHTS_UNIFORM},
        {.name = "tree", .sampler = LK_LIGHTS_TREE},
        {.name = "all", .sampler = LK_LIGHTS_ALL},
        {.name = "importance", .sampler = LK_LIGHTS_IMPORTANCE},
    };
    const size_t count = sizeof(rows) / sizeof(rows[0]);
    struct lk_settings settings = options->settings;
    struct lk_scene *scene = NULL;
    struct lk_image *reference = NULL;
    if (!(settings.time_s > 0.0))
        settings.time_s = DEFAULT_TIME_S;

    enum status status = (enum status)lk_scene_load(&scene, options->operands[1]);
    if (status == STATUS_OK)
        status = make_reference(&reference, scene, &settings, options);
    for (size_t i = 0; i < count && status == STATUS_OK; i++) {
        struct lk_image *image = NULL;
        status = render_timed(&image, scene, &settings, rows[i].sampler, settings.time_s,
                              settings.seed, options);
        if (status == STATUS_OK)
            status = (enum status)lk_compare(&rows[i].comparison, NULL, image, reference);
        if (status == STATUS_OK)
            rows[i].info = *lk_image_info(image);
        lk_image_free(image);
    }
    if (status == STATUS_OK && options->json)
        status = print_json(rows, count, options);
    else if (status == STATUS_OK)
        print_rows(rows, count, options);
    lk_image_free(reference);
    lk_scene_free(scene);
    return status;
}
