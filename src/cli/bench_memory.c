// What the ray queue takes, and what it brings.

#include <stdlib.h>

#include "cli/bench.h"
#include "cli/bench_results.h"

#define QUEUE_FIRST 15 // 2^15 paths
#define QUEUE_LAST  21

static const char *const default_scenes[] = {"build/scenes/cornell.glb", "build/scenes/deck.glb"};

static const struct bench_column columns[] = {
    {"scene", "scene", NULL},
    {"queue", "paths in flight", "%.0f"},
    {"rays_mb", "per-ray data, MB", "%.1f"},
    {"bytes_per_path", "bytes a path", "%.0f"},
    {"bvh_mb", "BVH, MB", "%.1f"},
    {"geometry_mb", "geometry, MB", "%.1f"},
    {"materials_mb", "materials, MB", "%.1f"},
    {"film_mb", "film, MB", "%.1f"},
    {"total_mb", "total, MB", "%.1f"},
    {"mrays_per_s", "Mrays/s", "%.2f"},
    {"of_best", "of the best, %", "%.1f"},
};

struct sample {
    struct lk_memory memory;
    double rays_per_s;
};

static enum status measure(struct sample *samples, struct lk_device_info *device, const char *file,
                           const struct bench_plan *plan)
{
    struct lk_scene *scene = NULL;
    enum status status = (enum status)lk_scene_load(&scene, file);
    for (int k = QUEUE_FIRST; k <= QUEUE_LAST && status == STATUS_OK; k++) {
        struct lk_image *image = NULL;
        struct lk_settings settings = bench_settings(plan, plan->sizes[1], "0");
        settings.queue = 1u << k;
        settings.time_s = plan->measure_s;
        // The first is not counted: PoCL compiles a kernel once more for its first large launch.
        for (int run = 0; run < 2 && status == STATUS_OK; run++) {
            lk_image_free(image);
            image = NULL;
            status = bench_render(&image, scene, &settings, plan);
        }
        if (status != STATUS_OK)
            break;
        const struct lk_render_info *info = lk_image_info(image);
        samples[k - QUEUE_FIRST] = (struct sample){
            .memory = info->scene.memory,
            .rays_per_s = (double)(info->rays_camera + info->rays_indirect + info->rays_shadow) /
                          info->time_s.render,
        };
        *device = info->device;
        lk_image_free(image);
    }
    lk_scene_free(scene);
    return status;
}

static void add_rows(struct bench_table *table, const char *file, const struct sample *samples)
{
    double best = 0.0;
    for (int k = 0; k <= QUEUE_LAST - QUEUE_FIRST; k++)
        best = samples[k].rays_per_s > best ? samples[k].rays_per_s : best;
    for (int k = 0; k <= QUEUE_LAST - QUEUE_FIRST; k++) {
        const struct lk_memory *memory = &samples[k].memory;
        const double queue = (double)(1u << (k + QUEUE_FIRST));
        bench_text(table, file);
        bench_number(table, queue);
        bench_number(table, (double)memory->rays * 1e-6);
        bench_number(table, (double)memory->rays / queue);
        bench_number(table, (double)memory->bvh * 1e-6);
        bench_number(table, (double)memory->geometry * 1e-6);
        bench_number(table, (double)memory->materials * 1e-6);
        bench_number(table, (double)memory->film * 1e-6);
        bench_number(table, (double)memory->total_device * 1e-6);
        bench_number(table, samples[k].rays_per_s * 1e-6);
        bench_number(table, 100.0 * samples[k].rays_per_s / best);
    }
}

enum status bench_memory(const struct options *options)
{
    struct bench_plan plan = bench_plan_of(options);
    struct bench_table table = {.key = "memory",
                                .title = "Memory, and speed by the size of the ray queue",
                                .columns = columns,
                                .column_count = sizeof(columns) / sizeof(columns[0])};
    struct lk_device_info device = {0};
    if (options->settings.time_s > 0.0)
        plan.measure_s = options->settings.time_s;
    enum status status = bench_folder(plan.folder);
    const char *const *files = options->operands[0] != NULL && options->operands[1] != NULL
                                   ? options->operands + 1
                                   : default_scenes;
    const size_t most = files == default_scenes ? 2 : OPERANDS_MAX - 1;
    for (size_t i = 0; i < most && files[i] != NULL && status == STATUS_OK; i++) {
        struct sample samples[QUEUE_LAST - QUEUE_FIRST + 1] = {0};
        status = bench_find_scene(files[i]);
        if (status == STATUS_OK)
            status = measure(samples, &device, files[i], &plan);
        if (status == STATUS_OK)
            add_rows(&table, files[i], samples);
    }
    if (status == STATUS_OK)
        status = bench_deliver(&table, &device, options, "memory");
    bench_table_free(&table);
    return status;
}
