#include <stdio.h>

#include "cli/bench.h"
#include "cli/bench_table.h"
#include "cli/progress.h"

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

static const struct bench_column columns[] = {
    {"sampler", "sampler", NULL},
    {"spp", "samples a pixel", "%.1f"},
    {"variance", "variance", "%.5g"},
    {"of_uniform", "of uniform's", "%.4f"},
    {"mrays_per_s", "Mrays/s", "%.2f"},
    {"ns_per_shadow_ray", "ns a shadow ray", "%.1f"},
    {"bytes_per_light", "bytes a light", "%.1f"},
};

static void fill(struct bench_table *out, const struct lights_row *rows, size_t count)
{
    for (size_t i = 0; i < count; i++) {
        const struct lk_render_info *row = &rows[i].info;
        const double rays = (double)(row->rays_camera + row->rays_indirect + row->rays_shadow);
        const uint64_t lights = row->scene.lights.drawn;
        bench_text(out, rows[i].name);
        bench_number(out, row->spp);
        bench_number(out, rows[i].comparison.variance);
        bench_number(out, rows[i].comparison.variance / rows[0].comparison.variance);
        bench_number(out, rays / row->time_s.render * 1e-6);
        bench_number(out, row->time_s.render * 1e9 / (double)row->rays_shadow);
        bench_number(out, (double)row->scene.memory.lights / (double)lights);
    }
}

static enum status print(const struct lights_row *rows, size_t count, const struct options *options)
{
    const struct lk_render_info *info = &rows[0].info;
    struct bench_table table = {.key = "samplers",
                                .title = "Light samplers at equal time",
                                .columns = columns,
                                .column_count = sizeof(columns) / sizeof(columns[0])};
    enum status status = STATUS_OK;
    fill(&table, rows, count);
    if (options->json) {
        struct json json = {0};
        bench_json_begin(&json, "lights", &info->device);
        json_string(&json, "scene", options->operands[1]);
        json_double(&json, "time_s", info->settings.time_s);
        json_uint(&json, "width", info->settings.width);
        json_uint(&json, "height", info->settings.height);
        json_uint(&json, "depth", info->settings.depth);
        json_uint(&json, "lights", info->scene.lights.drawn);
        bench_table_json(&json, &table);
        json_object_end(&json);
        status = json_print(&json);
    } else {
        printf("%s, %u x %u, depth %u, %g s each, %llu lights, %s\n", options->operands[1],
               info->settings.width, info->settings.height, info->settings.depth,
               info->settings.time_s, (unsigned long long)info->scene.lights.drawn,
               info->device.name);
        bench_table_print(stdout, &table);
    }
    bench_table_free(&table);
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
    if (status == STATUS_OK)
        status = print(rows, count, options);
    lk_image_free(reference);
    lk_scene_free(scene);
    return status;
}
