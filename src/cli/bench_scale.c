// Cost against size: triangles, then lights.

#include <stdlib.h>
#include <unistd.h>

#include "cli/bench.h"
#include "cli/bench_cave.h"
#include "cli/bench_results.h"

#define FEW_LIGHTS     64     // while triangles grow
#define SOME_TRIANGLES 100000 // while lights grow

static const struct bench_column columns[] = {
    {"series", "grows", NULL},
    {"sampler", "light sampler", NULL},
    {"triangles", "triangles", "%.0f"},
    {"lights", "lights", "%.0f"},
    {"import_s", "import, s", "%.2f"},
    {"prepare_s", "preparation, s", "%.2f"},
    {"bvh_bytes_per_triangle", "BVH, bytes a triangle", "%.0f"},
    {"lights_mb", "lights, MB", "%.2f"},
    {"total_mb", "on the device, MB", "%.0f"},
    {"peak_host_mb", "host at most so far, MB", "%.0f"},
    {"mrays_per_s", "Mrays/s", "%.2f"},
    {"ns_per_sample", "ns a path", "%.0f"},
};

struct step {
    const char *series, *sampler_name;
    uint32_t triangles, lights;
    enum lk_light_sampler sampler;
};

static enum status measure(struct bench_table *table, struct lk_device_info *device,
                           const struct step *step, const char *path, const struct bench_plan *plan)
{
    struct lk_scene *scene = NULL;
    struct lk_image *image = NULL;
    struct lk_settings settings = bench_settings(plan, plan->sizes[0], "0");
    settings.light_sampler = step->sampler;
    settings.time_s = plan->measure_s;
    enum status status = bench_cave_write(path, step->triangles, step->lights);
    if (status == STATUS_OK)
        status = (enum status)lk_scene_load(&scene, path);
    if (status == STATUS_OK)
        status = bench_render(&image, scene, &settings, plan);
    if (status == STATUS_OK) {
        const struct lk_render_info *info = lk_image_info(image);
        const struct lk_memory *memory = &info->scene.memory;
        const double rays = (double)(info->rays_camera + info->rays_indirect + info->rays_shadow);
        bench_text(table, step->series);
        bench_text(table, step->sampler_name);
        bench_number(table, (double)info->scene.triangles);
        bench_number(table, (double)info->scene.lights.drawn);
        bench_number(table, info->time_s.import);
        bench_number(table, info->time_s.prepare);
        bench_number(table, (double)memory->bvh / (double)info->scene.triangles);
        bench_number(table, (double)memory->lights * 1e-6);
        bench_number(table, (double)memory->total_device * 1e-6);
        bench_number(table, (double)memory->peak_host * 1e-6);
        bench_number(table, rays / info->time_s.render * 1e-6);
        bench_number(table, info->time_s.render * 1e9 / (double)info->paths);
        *device = info->device;
    }
    lk_image_free(image);
    lk_scene_free(scene);
    unlink(path);
    return status;
}

enum status bench_scale(const struct options *options)
{
    struct bench_plan plan = bench_plan_of(options);
    const uint32_t most_triangles = options->quick ? 1000000 : 10000000;
    const uint32_t most_lights = options->quick ? 10000 : 1000000;
    struct bench_table table = {.key = "scale",
                                .title = "Cost against size",
                                .columns = columns,
                                .column_count = sizeof(columns) / sizeof(columns[0])};
    struct lk_device_info device = {0};
    char path[4096];
    if (options->settings.time_s > 0.0)
        plan.measure_s = options->settings.time_s;
    enum status status = bench_folder(plan.folder);
    if (status == STATUS_OK)
        status = bench_path(path, sizeof(path), plan.folder, "scale.glb");
    for (uint32_t n = 10000; n <= most_triangles && status == STATUS_OK; n *= 10) {
        const struct step step = {"triangles", "importance", n, FEW_LIGHTS, LK_LIGHTS_IMPORTANCE};
        status = measure(&table, &device, &step, path, &plan);
    }
    for (uint32_t n = 1; n <= most_lights && status == STATUS_OK; n *= 10) {
        const struct step steps[2] = {
            {"lights", "importance", SOME_TRIANGLES, n, LK_LIGHTS_IMPORTANCE},
            {"lights", "tree", SOME_TRIANGLES, n, LK_LIGHTS_TREE},
        };
        for (int i = 0; i < 2 && status == STATUS_OK; i++)
            status = measure(&table, &device, &steps[i], path, &plan);
    }
    if (status == STATUS_OK)
        status = bench_deliver(&table, &device, options, "scale");
    bench_table_free(&table);
    return status;
}
