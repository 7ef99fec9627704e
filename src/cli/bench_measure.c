// Tables 1 to 3 and the pictures of one scene.

#include <errno.h>
#include <math.h>
#include <string.h>
#include <unistd.h>

#include "cli/bench_results.h"
#include "cli/progress.h"

#define GREY              0.35 // what a picture's mean is exposed to
#define CONVERGE_S        20.0 // today's devices do in it what the GTX 260+ did in the 12 minutes
#define REFERENCE_TIMES   10   // a reference takes so many times as long
#define QUICK_CONVERGE_S  3.0
#define QUICK_REFERENCE_S 12.0

struct bench_plan bench_plan_of(const struct options *options)
{
    const bool quick = options->quick;
    const double time_s = options->settings.time_s;
    struct bench_plan plan = {
        .options = options,
        .folder = options->out,
        .sizes = {quick ? 128 : 512, quick ? 256 : 1024},
        .measure_s = quick ? 0.4 : 3.0,
        .converge_s = time_s > 0.0 ? time_s
                      : quick      ? QUICK_CONVERGE_S
                                   : CONVERGE_S,
    };
    plan.reference_s = options->reference_time_s > 0.0 ? options->reference_time_s
                       : quick                         ? QUICK_REFERENCE_S
                                                       : REFERENCE_TIMES * plan.converge_s;
    plan.picture_s = 0.25 * plan.converge_s;
    return plan;
}

enum status bench_find_scene(const char *file)
{
    if (access(file, R_OK) == 0)
        return STATUS_OK;
    return status_fail(STATUS_IO, "%s: %s; scripts/make_scenes makes the scenes of bench", file,
                       strerror(errno));
}

struct lk_settings bench_settings(const struct bench_plan *plan, uint32_t size, const char *camera)
{
    struct lk_settings settings = plan->options->settings;
    settings.light_sampler = LK_LIGHTS_TREE;
    settings.width = settings.height = size;
    settings.camera = camera;
    settings.spp = 0;
    settings.time_s = 0.0;
    return settings;
}

enum status bench_render(struct lk_image **out, struct lk_scene *scene,
                         const struct lk_settings *settings, const struct bench_plan *plan)
{
    struct progress progress;
    progress_init(&progress, plan->options->quiet, false);
    progress.quiet = progress.quiet || !progress.terminal; // too many renders for a log
    const struct lk_progress_hook hook = {progress_report, &progress};
    *out = NULL;
    const enum status status = (enum status)lk_render(out, scene, settings, &hook);
    progress_end(&progress);
    if (status != STATUS_OK) {
        lk_image_free(*out); // of an interrupted one
        *out = NULL;
    }
    return status;
}

enum status bench_deliver(const struct bench_table *table, const struct lk_device_info *device,
                          const struct options *options, const char *experiment)
{
    char name[64];
    struct json json = {0};
    struct bench_text_file file = {0};
    bench_json_begin(&json, experiment, device);
    bench_table_json(&json, table);
    snprintf(name, sizeof(name), "%s.json", experiment);
    enum status status = bench_json_write(&json, options->out, name);
    if (status == STATUS_OK)
        status = bench_table_csv(table, options->out);
    snprintf(name, sizeof(name), "%s.md", experiment);
    if (status == STATUS_OK)
        status = bench_file_open(&file, options->out, name);
    if (status == STATUS_OK) {
        bench_table_markdown(file.stream, table);
        fprintf(file.stream, "\n%s, lightkiln %s.\n\n![%s](%s.png)\n", device->name, lk_version(),
                table->title, experiment);
        status = bench_file_close(&file);
    }
    if (status == STATUS_OK && options->json)
        fputs(json.text, stdout);
    else if (status == STATUS_OK)
        bench_table_print(stdout, table);
    json_free(&json);
    return status;
}

double bench_mean(const struct lk_image *image)
{
    uint32_t width = 0;
    uint32_t height = 0;
    const float *pixels = lk_image_pixels(image, &width, &height);
    const size_t count = (size_t)width * height * 3;
    double sum = 0.0;
    for (size_t i = 0; i < count; i++)
        sum += (double)pixels[i];
    return sum / (double)count;
}

enum status bench_picture(const struct lk_image *image, double mean, const struct bench_plan *plan,
                          const char *name)
{
    char file[160];
    char path[4096];
    snprintf(file, sizeof(file), "%s.jpg", name);
    const enum status status = bench_path(path, sizeof(path), plan->folder, file);
    if (status != STATUS_OK)
        return status;
    const struct lk_display display = {
        .exposure_ev = mean > 0.0 ? (float)log2(GREY / mean) : 0.0f,
        .tonemap = LK_TONEMAP_ACES,
    };
    return (enum status)lk_image_write(image, path, &display);
}

static bool begins_with(const char *text, const char *start)
{
    return strncmp(text, start, strlen(start)) == 0;
}

// Table 3's three classes of kernels.
static void add_shares(struct bench_speed *out, const struct lk_render_info *info)
{
    double total_s = 0.0;
    for (uint32_t i = 0; i < info->kernel_count; i++)
        total_s += info->kernels[i].time_s;
    for (uint32_t i = 0; i < info->kernel_count && total_s > 0.0; i++) {
        const double share = info->kernels[i].time_s / total_s;
        if (begins_with(info->kernels[i].name, "trace"))
            out->traversal += share;
        else if (begins_with(info->kernels[i].name, "direct")) // and directional
            out->lighting += share;
        else
            out->others += share;
    }
}

// One configuration: without events for its speed, with them for its kernels.
static enum status measure_speed(struct bench_speed *out, struct bench_scene *of,
                                 struct lk_scene *scene, const struct lk_settings *settings,
                                 const struct bench_plan *plan)
{
    struct lk_image *image = NULL;
    enum status status = bench_render(&image, scene, settings, plan);
    if (status != STATUS_OK)
        return status;
    const struct lk_render_info *info = lk_image_info(image);
    const double rays = (double)(info->rays_camera + info->rays_indirect + info->rays_shadow);
    out->rays_per_s = rays / info->time_s.render;
    out->spp = info->spp;
    out->render_s = info->time_s.render;
    of->device = info->device;
    of->used = info->scene.memory;
    of->queue = info->settings.queue;
    lk_image_free(image);
    if (settings->width != plan->sizes[1])
        return STATUS_OK; // Table 3 is of the larger size

    struct lk_settings profiled = *settings;
    profiled.profile = true;
    status = bench_render(&image, scene, &profiled, plan);
    if (status == STATUS_OK)
        add_shares(out, lk_image_info(image));
    lk_image_free(image);
    return status;
}

static enum status measure_speeds(struct bench_scene *out, struct lk_scene *scene,
                                  const struct bench_plan *plan)
{
    for (int s = 0; s < 2; s++) {
        struct lk_settings settings = bench_settings(plan, plan->sizes[s], out->views[0].camera);
        settings.time_s = plan->measure_s;
        for (int d = 0; d < 2; d++) {
            for (int n = 0; n < 2; n++) {
                settings.depth = thesis_depths[d];
                settings.shadow_rays = thesis_shadow_rays[n];
                const enum status status =
                    measure_speed(&out->speed[s][d][n], out, scene, &settings, plan);
                if (status != STATUS_OK)
                    return status;
            }
        }
    }
    return STATUS_OK;
}

// What half of the thesis's per-ray data cost in speed.
static enum status measure_small_queue(struct bench_scene *out, struct lk_scene *scene,
                                       const struct bench_plan *plan)
{
    struct lk_image *image = NULL;
    struct lk_settings settings = bench_settings(plan, plan->sizes[1], out->views[0].camera);
    const double each = (double)out->used.rays / out->queue;
    const double most = 0.5e6 * THESIS_RAYS_MB / each;
    out->small_queue = most < out->queue ? (uint32_t)most : out->queue;
    if (out->small_queue == out->queue) { // the default is small enough
        out->small_rays_per_s = out->speed[1][1][0].rays_per_s;
        return STATUS_OK;
    }
    settings.queue = out->small_queue;
    settings.time_s = plan->measure_s;
    settings.depth = thesis_depths[1];
    settings.shadow_rays = thesis_shadow_rays[0];
    const enum status status = bench_render(&image, scene, &settings, plan);
    if (status != STATUS_OK)
        return status;
    const struct lk_render_info *info = lk_image_info(image);
    out->small_rays_per_s =
        (double)(info->rays_camera + info->rays_indirect + info->rays_shadow) / info->time_s.render;
    lk_image_free(image);
    return STATUS_OK;
}

static bool has_camera(const struct lk_scene *scene, const char *name)
{
    const char *camera = NULL;
    for (size_t i = 0; (camera = lk_scene_camera(scene, i)) != NULL; i++)
        if (strcmp(camera, name) == 0)
            return true;
    return false;
}

// The thesis's views, or the first camera.
static void choose_views(struct bench_scene *out, const struct lk_scene *scene)
{
    const struct thesis_scene *thesis = out->thesis;
    for (int i = 0; thesis != NULL && i < BENCH_VIEWS_MAX; i++) {
        if (thesis->cameras[i] == NULL || !has_camera(scene, thesis->cameras[i]))
            continue;
        struct bench_view *view = &out->views[out->view_count++];
        snprintf(view->camera, sizeof(view->camera), "%s", thesis->cameras[i]);
        snprintf(view->title, sizeof(view->title), "%s", thesis->views[i]);
        snprintf(view->name, sizeof(view->name), "%.30s_%.30s", thesis->name, thesis->cameras[i]);
        view->thesis_faster = thesis->faster_in_time[i];
        view->thesis_better = thesis->better_by_rays[i];
    }
    if (out->view_count == 0) {
        struct bench_view *view = &out->views[out->view_count++];
        snprintf(view->camera, sizeof(view->camera), "0");
        snprintf(view->title, sizeof(view->title), "%s", out->name);
        snprintf(view->name, sizeof(view->name), "%s", out->name);
    }
}

// Figure 11: what every camera sees.
static enum status make_pictures(struct bench_scene *of, struct lk_scene *scene,
                                 const struct bench_plan *plan)
{
    for (unsigned i = 0; i < BENCH_PICTURES_MAX && lk_scene_camera(scene, i) != NULL; i++) {
        char index[24];
        char name[160];
        struct lk_image *image = NULL;
        snprintf(index, sizeof(index), "%u", i);
        snprintf(of->pictures[i], sizeof(of->pictures[i]), "%.60s", lk_scene_camera(scene, i));
        of->picture_count = i + 1;
        snprintf(name, sizeof(name), "figure11_%s_%s", of->name, of->pictures[i]);
        struct lk_settings settings = bench_settings(plan, 0, index);
        settings.light_sampler = LK_LIGHTS_AUTO;
        settings.width = plan->sizes[1];
        settings.time_s = plan->picture_s;
        enum status status = bench_render(&image, scene, &settings, plan);
        if (status == STATUS_OK)
            status = bench_picture(image, bench_mean(image), plan, name);
        lk_image_free(image);
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

// "build/scenes/deck.glb" is "deck".
static void name_scene(char *out, size_t size, const char *file)
{
    const char *slash = strrchr(file, '/');
    snprintf(out, size, "%s", slash != NULL ? slash + 1 : file);
    char *dot = strrchr(out, '.');
    if (dot != NULL)
        *dot = '\0';
}

enum status bench_scene_measure(struct bench_scene *out, const char *file,
                                const struct bench_plan *plan)
{
    struct lk_scene *scene = NULL;
    *out = (struct bench_scene){.file = file};
    name_scene(out->name, sizeof(out->name), file);
    out->thesis = thesis_find(out->name);
    if (!plan->options->quiet)
        fprintf(stderr, "lightkiln: %s\n", file);

    enum status status = (enum status)lk_scene_load(&scene, file);
    if (status != STATUS_OK)
        return status;
    choose_views(out, scene);
    for (int s = 0; s < 2 && status == STATUS_OK; s++) {
        struct lk_settings settings = bench_settings(plan, 512u << s, out->views[0].camera);
        settings.spp = 64; // so that the image alone bounds the queue
        status = (enum status)lk_scene_info(&out->info[s], scene, &settings);
        out->info[s].file = file;
    }
    if (status == STATUS_OK)
        status = measure_speeds(out, scene, plan);
    if (status == STATUS_OK)
        status = measure_small_queue(out, scene, plan);
    for (unsigned i = 0; i < out->view_count && status == STATUS_OK; i++) {
        out->views[i].has_curves = out->info[0].lights.drawn > 0;
        status = bench_view_measure(&out->views[i], scene, plan);
    }
    if (status == STATUS_OK)
        status = make_pictures(out, scene, plan);
    lk_scene_free(scene);
    return status;
}
