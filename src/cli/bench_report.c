// Section 4 of the thesis, run again: what is measured, and how it is told.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "cli/bench_results.h"

#define MB                 1e-6
#define TABLE(name, title) table_of(#name, title, name##_columns, COUNT(name##_columns))
#define COUNT(array)       (sizeof(array) / sizeof((array)[0]))

static const char *const default_scenes[] = {"build/scenes/cornell.glb",
                                             "build/scenes/cathedral.glb",
                                             "build/scenes/atrium.glb", "build/scenes/deck.glb"};

// ---- Tables

static const struct bench_column table1_columns[] = {
    {"scene", "scene", NULL},
    {"triangles", "triangles", "%.0f"},
    {"point", "point lights", "%.0f"},
    {"directional", "directional", "%.0f"},
    {"area", "area", "%.0f"},
    {"emissive_triangles", "emissive triangles", "%.0f"},
    {"bvh_mb", "BVH, MB", "%.1f"},
    {"geometry_mb", "geometry, MB", "%.1f"},
    {"materials_mb", "materials, MB", "%.1f"},
    {"lights_mb", "lights, MB", "%.1f"},
    {"queue", "paths in flight", "%.0f"},
    {"rays_mb", "per-ray data, MB", "%.1f"},
    {"pixel_rays_mb", "one path a pixel, MB", "%.1f"},
    {"film_mb", "film, MB", "%.1f"},
    {"total_mb", "total, MB", "%.1f"},
    {"thesis_scene", "thesis", NULL},
    {"thesis_triangles", "triangles", "%.0f"},
    {"thesis_point", "point", "%.0f"},
    {"thesis_directional", "directional", "%.0f"},
    {"thesis_area", "area", "%.0f"},
    {"thesis_bvh_mb", "BVH, MB", "%.1f"},
    {"thesis_geometry_mb", "geometry, MB", "%.1f"},
    {"thesis_materials_mb", "materials, MB", "%.1f"},
    {"thesis_total_mb", "total, MB", "%.1f"},
};

static const struct bench_column table2_columns[] = {
    {"scene", "scene", NULL},
    {"size", "pixels a side", "%.0f"},
    {"depth", "depth", "%.0f"},
    {"shadow_rays", "shadow rays", "%.0f"},
    {"mrays_per_s", "Mrays/s", "%.2f"},
    {"spp", "samples a pixel", "%.1f"},
    {"thesis_mrays_per_s", "thesis, Mrays/s", "%.1f"},
    {"times_thesis", "times the thesis's", "%.1f"},
};

static const struct bench_column table3_columns[] = {
    {"scene", "scene", NULL},
    {"depth", "depth", "%.0f"},
    {"shadow_rays", "shadow rays", "%.0f"},
    {"traversal", "traversal, %", "%.1f"},
    {"lighting", "lighting, %", "%.1f"},
    {"others", "others, %", "%.1f"},
    {"thesis_traversal", "thesis: traversal, %", "%.1f"},
    {"thesis_lighting", "lighting, %", "%.1f"},
    {"thesis_others", "others, %", "%.1f"},
};

static const struct bench_column figure6_columns[] = {
    {"scene", "scene", NULL},
    {"depth", "depth", "%.0f"},
    {"shadow_rays", "shadow rays", "%.0f"},
    {"cost", "a shadow ray's cost", "%.2f"},
    {"thesis_cost", "thesis", "%.2f"},
};

static const struct bench_column figure7_columns[] = {
    {"view", "view", NULL},
    {"camera", "camera", NULL},
    {"shadow_rays", "shadow rays", "%.0f"},
    {"time_s", "time, s", "%.4g"},
    {"rays", "rays", "%.4g"},
    {"spp", "samples a pixel", "%.0f"},
    {"variance", "variance, lux^2", "%.4g"},
};

static const struct bench_column views_columns[] = {
    {"view", "view", NULL},
    {"scene", "scene", NULL},
    {"camera", "camera", NULL},
    {"name", "in file names", NULL},
    {"mean", "mean, lux", "%.4g"},
    {"reference_spp", "reference, samples a pixel", "%.0f"},
    {"reference_s", "reference, s", "%.1f"},
};

static struct bench_table table_of(const char *key, const char *title,
                                   const struct bench_column *columns, size_t count)
{
    return (struct bench_table){
        .key = key, .title = title, .columns = columns, .column_count = count};
}

static void fill_table1(struct bench_table *out, const struct bench_results *results)
{
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct bench_scene *scene = &results->scenes[i];
        const struct lk_scene_info *info = &scene->info[1];
        const struct thesis_scene *thesis = scene->thesis;
        const struct thesis_scene none = {.triangles = NAN,
                                          .point = NAN,
                                          .directional = NAN,
                                          .area = NAN,
                                          .bvh_mb = NAN,
                                          .geometry_mb = NAN,
                                          .material_mb = NAN,
                                          .footprint_mb = NAN};
        const struct thesis_scene *there = thesis != NULL ? thesis : &none;
        bench_text(out, scene->name);
        bench_number(out, (double)info->triangles);
        bench_number(out, (double)(info->lights.point + info->lights.spot));
        bench_number(out, (double)info->lights.directional);
        bench_number(out, (double)(info->lights.rect + info->lights.disc));
        bench_number(out, (double)info->lights.emissive_triangles);
        bench_number(out, (double)scene->used.bvh * MB);
        bench_number(out, (double)scene->used.geometry * MB);
        bench_number(out, (double)scene->used.materials * MB);
        bench_number(out, (double)scene->used.lights * MB);
        bench_number(out, scene->queue);
        bench_number(out, (double)scene->used.rays * MB);
        bench_number(out, bench_path_size(scene) * THESIS_PIXELS * MB);
        bench_number(out, (double)info->memory.film * MB);
        bench_number(out, (double)bench_total_memory(scene, scene->queue) * MB);
        bench_text(out, thesis != NULL ? thesis->thesis : "-");
        bench_number(out, there->triangles);
        bench_number(out, there->point);
        bench_number(out, there->directional);
        bench_number(out, there->area);
        bench_number(out, there->bvh_mb);
        bench_number(out, there->geometry_mb);
        bench_number(out, there->material_mb);
        bench_number(out, there->footprint_mb);
    }
}

static void fill_table2(struct bench_table *out, const struct bench_results *results)
{
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct bench_scene *scene = &results->scenes[i];
        for (int k = 0; k < 8; k++) {
            const int size = k >> 2;
            const int depth = k >> 1 & 1;
            const int shadow = k & 1;
            const struct bench_speed *speed = &scene->speed[size][depth][shadow];
            const double thesis =
                scene->thesis != NULL ? scene->thesis->mrays[size][depth][shadow] : NAN;
            bench_text(out, scene->name);
            bench_number(out, results->plan.sizes[size]);
            bench_number(out, thesis_depths[depth]);
            bench_number(out, thesis_shadow_rays[shadow]);
            bench_number(out, speed->rays_per_s * 1e-6);
            bench_number(out, speed->spp);
            bench_number(out, thesis);
            bench_number(out, speed->rays_per_s * 1e-6 / thesis);
        }
    }
}

// 0 is what the thesis does not tell.
static double told(double value)
{
    return value > 0.0 ? value : NAN;
}

static void fill_table3(struct bench_table *shares, struct bench_table *costs,
                        const struct bench_results *results)
{
    const struct thesis_scene none = {0};
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct bench_scene *scene = &results->scenes[i];
        const struct thesis_scene *thesis = scene->thesis != NULL ? scene->thesis : &none;
        for (int k = 0; k < 4; k++) {
            const int depth = k >> 1;
            const int shadow = k & 1;
            const struct bench_speed *speed = &scene->speed[1][depth][shadow];
            bench_text(shares, scene->name);
            bench_number(shares, thesis_depths[depth]);
            bench_number(shares, thesis_shadow_rays[shadow]);
            bench_number(shares, 100.0 * speed->traversal);
            bench_number(shares, 100.0 * speed->lighting);
            bench_number(shares, 100.0 * speed->others);
            bench_number(shares, told(thesis->traversal[depth][shadow]));
            bench_number(shares, told(thesis->lighting[depth][shadow]));
            bench_number(shares, told(thesis->others[depth][shadow]));
            if (scene->info[0].lights.drawn == 0)
                continue; // no shadow rays of that kind
            bench_text(costs, scene->name);
            bench_number(costs, thesis_depths[depth]);
            bench_number(costs, thesis_shadow_rays[shadow]);
            bench_number(costs, bench_shadow_cost(scene, depth, shadow));
            bench_number(costs, told(thesis->lighting[depth][shadow]) /
                                    thesis->traversal[depth][shadow] / thesis_shadow_rays[shadow]);
        }
    }
}

static void fill_curves(struct bench_table *curves, struct bench_table *views,
                        const struct bench_results *results)
{
    for (unsigned i = 0; i < results->scene_count; i++) {
        for (unsigned v = 0; v < results->scenes[i].view_count; v++) {
            const struct bench_view *view = &results->scenes[i].views[v];
            bench_text(views, view->title);
            bench_text(views, results->scenes[i].name);
            bench_text(views, view->camera);
            bench_text(views, view->name);
            bench_number(views, view->mean);
            bench_number(views, told(view->reference_spp));
            bench_number(views, told(view->reference_s));
            for (int n = 0; n < 2; n++) {
                for (unsigned p = 0; p < view->curves[n].count; p++) {
                    const struct bench_point *point = &view->curves[n].points[p];
                    bench_text(curves, view->title);
                    bench_text(curves, view->camera);
                    bench_number(curves, thesis_shadow_rays[n]);
                    bench_number(curves, point->time_s);
                    bench_number(curves, point->rays);
                    bench_number(curves, point->spp);
                    bench_number(curves, point->variance);
                }
            }
        }
    }
}

// ---- Files

enum { TABLE1, TABLE2, TABLE3, FIGURE6, FIGURE7, VIEWS, CONCLUSIONS, TABLES };

static void make_tables(struct bench_table *tables, const struct bench_results *results)
{
    tables[TABLE1] = TABLE(table1, "Table 1: scenes, and memory at 1024 x 1024");
    tables[TABLE2] = TABLE(table2, "Table 2: million rays a second");
    tables[TABLE3] = TABLE(table3, "Table 3: shares of the kernels' time");
    tables[FIGURE6] = TABLE(figure6, "Figure 6: relative cost of a shadow ray");
    tables[FIGURE7] = TABLE(figure7, "Figures 7 and 8: variance of the irradiance");
    tables[VIEWS] = TABLE(views, "Views and their references");
    fill_table1(&tables[TABLE1], results);
    fill_table2(&tables[TABLE2], results);
    fill_table3(&tables[TABLE3], &tables[FIGURE6], results);
    fill_curves(&tables[FIGURE7], &tables[VIEWS], results);
    bench_conclusions(&tables[CONCLUSIONS], results);
}

static void write_pictures(FILE *file, const struct bench_results *results)
{
    fprintf(file, "\n### Figure 9: irradiance, direct light and all of it (the references)\n\n"
                  "| view | direct | all |\n|---|---|---|\n");
    for (unsigned i = 0; i < results->scene_count; i++)
        for (unsigned v = 0; v < results->scenes[i].view_count; v++) {
            const struct bench_view *view = &results->scenes[i].views[v];
            fprintf(file, "| %s | ![](figure9_%s_direct.jpg) | ![](figure9_%s_all.jpg) |\n",
                    view->title, view->name, view->name);
        }
    fprintf(file, "\n### Figure 10: after the same time, with 1 and with 4 shadow rays\n\n"
                  "| view | 1 shadow ray | 4 shadow rays |\n|---|---|---|\n");
    for (unsigned i = 0; i < results->scene_count; i++)
        for (unsigned v = 0; v < results->scenes[i].view_count; v++) {
            const struct bench_view *view = &results->scenes[i].views[v];
            if (view->has_curves)
                fprintf(file, "| %s | ![](figure10_%s_1.jpg) | ![](figure10_%s_4.jpg) |\n",
                        view->title, view->name, view->name);
        }
    fprintf(file, "\n### Figure 11: what the cameras see\n\n");
    for (unsigned i = 0; i < results->scene_count; i++)
        for (unsigned c = 0; c < results->scenes[i].picture_count; c++)
            fprintf(file, "![%s](figure11_%s_%s.jpg)\n", results->scenes[i].name,
                    results->scenes[i].name, results->scenes[i].pictures[c]);
}

static void write_markdown(FILE *file, const struct bench_table *tables,
                           const struct bench_results *results)
{
    const struct lk_device_info *device = &results->scenes[0].device;
    const struct bench_plan *plan = &results->plan;
    fprintf(file,
            "## %s\n\n"
            "lightkiln %s; %s, driver %s, %u compute units. The thesis's numbers, beside ours, are "
            "of a " THESIS_DEVICE ".\n\n"
            "Light tree, one camera a scene. Table 2: %g s a cell; %u and %u pixels a side%s. "
            "Table 3 and Figure 6: %u pixels, from event times. Figures 7 to 10: irradiance at %u "
            "pixels, depth 5, about %g s for each curve.%s\n",
            device->name, lk_version(), device->platform, device->driver, device->compute_units,
            plan->measure_s, plan->sizes[0], plan->sizes[1],
            plan->options->quick ? " where the thesis has 512 and 1024" : "", plan->sizes[1],
            plan->sizes[0], plan->converge_s,
            strcmp(device->type, "cpu") == 0
                ? " The stage that adds the last light also sends paths on here: lighting, "
                  "and a shadow ray's cost, hold that."
                : "");
    bench_table_markdown(file, &tables[CONCLUSIONS]);
    bench_table_markdown(file, &tables[TABLE1]);
    fprintf(file, "\n![Table 1](table1.png)\n");
    bench_table_markdown(file, &tables[TABLE2]);
    fprintf(file, "\n![Table 2](table2.png)\n");
    bench_table_markdown(file, &tables[TABLE3]);
    fprintf(file, "\n![Table 3](table3.png)\n");
    bench_table_markdown(file, &tables[FIGURE6]);
    fprintf(file, "\n![Figure 6](figure6.png)\n");
    bench_table_markdown(file, &tables[VIEWS]);
    fprintf(file, "\n### Figures 7 and 8: variance over time and over rays\n\n"
                  "![Figure 7](figure7.png)\n\n![Figure 8](figure8.png)\n");
    write_pictures(file, results);
}

static enum status write_report(const struct bench_table *tables,
                                const struct bench_results *results)
{
    struct bench_text_file file = {0};
    enum status status = bench_file_open(&file, results->plan.folder, "report.md");
    if (status != STATUS_OK)
        return status;
    write_markdown(file.stream, tables, results);
    return bench_file_close(&file);
}

static void write_plan(struct json *json, const struct bench_plan *plan)
{
    json_object(json, "plan");
    json_bool(json, "quick", plan->options->quick);
    json_uint(json, "small_size", plan->sizes[0]);
    json_uint(json, "large_size", plan->sizes[1]);
    json_double(json, "measure_s", plan->measure_s);
    json_double(json, "converge_s", plan->converge_s);
    json_double(json, "reference_s", plan->reference_s);
    json_object_end(json);
}

// Writes all files, and says on stdout what they hold if that is the end of it.
static enum status write_results(const struct bench_results *results, bool is_end)
{
    struct bench_table tables[TABLES] = {0};
    struct json json = {0};
    make_tables(tables, results);
    bench_json_begin(&json, "report", &results->scenes[0].device);
    write_plan(&json, &results->plan);
    enum status status = STATUS_OK;
    for (int i = 0; i < TABLES; i++) {
        bench_table_json(&json, &tables[i]);
        if (status == STATUS_OK)
            status = bench_table_csv(&tables[i], results->plan.folder);
    }
    if (status == STATUS_OK)
        status = bench_json_write(&json, results->plan.folder, "bench.json");
    if (status == STATUS_OK)
        status = write_report(tables, results);
    if (status == STATUS_OK && is_end && results->plan.options->json)
        fputs(json.text, stdout);
    else if (status == STATUS_OK && is_end)
        for (int i = 0; i < TABLES; i++)
            bench_table_print(stdout, &tables[i]);
    for (int i = 0; i < TABLES; i++)
        bench_table_free(&tables[i]);
    json_free(&json);
    return status;
}

// ---- The command

enum status bench_report(const struct options *options)
{
    struct bench_results *results = calloc(1, sizeof(*results));
    if (results == NULL)
        return status_fail(STATUS_NO_MEMORY, "bench: not enough memory");
    results->plan = bench_plan_of(options);
    enum status status = bench_folder(results->plan.folder);
    const bool named = options->operands[0] != NULL && options->operands[1] != NULL;
    for (unsigned i = 0; status == STATUS_OK; i++) {
        const char *file = NULL;
        if (named)
            file = i + 1 < OPERANDS_MAX ? options->operands[i + 1] : NULL;
        else
            file = i < COUNT(default_scenes) ? default_scenes[i] : NULL;
        if (file == NULL)
            break;
        status = bench_find_scene(file);
        if (status != STATUS_OK)
            break;
        status = bench_scene_measure(&results->scenes[i], file, &results->plan);
        if (status != STATUS_OK)
            break;
        results->scene_count = i + 1;
        status = write_results(results, false); // so that what ends it early takes one scene only
    }
    if (status == STATUS_OK)
        status = write_results(results, true);
    free(results);
    return status;
}
