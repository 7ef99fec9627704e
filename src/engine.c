// The public API's work: scenes, devices, and lk_render(), which is the program on a page.

#include "engine.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "core/log.h"
#include "plan.h"
#include "prep/camera.h"
#include "prepare.h"
#include "render.h"
#include "scene/gltf_import.h"
#include "settings.h"
#include "shared/bvh_wide.h"
#include "shared/path.h"
#include "shared/ray.h"

// ---- Scenes

enum lk_status lk_scene_load(struct lk_scene **out, const char *path)
{
    const double start = clock_seconds();
    struct lk_scene *scene = calloc(1, sizeof(*scene));
    if (scene == NULL)
        return (enum lk_status)status_fail(STATUS_NO_MEMORY, "%s: not enough memory", path);
    const enum status status = gltf_import(&scene->scene, path);
    if (status != STATUS_OK) {
        free(scene);
        return (enum lk_status)status;
    }
    scene->import_s = clock_seconds() - start;
    *out = scene;
    return LK_OK;
}

void lk_scene_free(struct lk_scene *scene)
{
    if (scene == NULL)
        return;
    surroundings_free(&scene->surroundings);
    prepared_free(&scene->prepared);
    scene_free(&scene->scene);
    free(scene);
}

const char *lk_scene_camera(const struct lk_scene *scene, size_t index)
{
    if (index >= scene->scene.camera_count)
        return NULL;
    const struct scene_camera *camera = &scene->scene.cameras[index];
    return camera->name[0] != '\0' ? camera->name : camera->node_name;
}

enum lk_status lk_scene_info(struct lk_scene_info *out, struct lk_scene *scene,
                             const struct lk_settings *settings)
{
    struct camera camera;
    struct lk_settings chosen = *settings;
    settings_choose_sampler(&chosen);
    if (chosen.bvh == LK_BVH_AUTO)
        chosen.bvh = LK_BVH_BINARY;
    enum status status = settings_check(settings);
    if (status == STATUS_OK)
        status = prepare_scene(scene, &chosen, 1u << chosen.bvh);
    if (status == STATUS_OK)
        status = camera_build(&camera, &scene->scene, &scene->prepared.geometry, settings->camera,
                              settings->width, settings->height);
    if (status != STATUS_OK)
        return (enum lk_status)status;
    const uint64_t pixels = (uint64_t)camera.width * camera.height;
    plan_describe(out, scene, &chosen, 1u << chosen.bvh, &camera,
                  pixels < SETTINGS_QUEUE_GPU ? (uint32_t)pixels : SETTINGS_QUEUE_GPU);
    return LK_OK;
}

// ---- Devices

void engine_describe_device(struct lk_device_info *out, const struct gpu_info *info)
{
    *out = (struct lk_device_info){
        .platform_index = info->platform_index,
        .device_index = info->device_index,
        .compute_units = info->compute_units,
        .global_memory = info->global_memory,
        .max_allocation = info->max_allocation,
        .local_memory = info->local_memory,
        .usable = info->usable,
    };
    snprintf(out->platform, sizeof(out->platform), "%s", info->platform);
    snprintf(out->name, sizeof(out->name), "%s", info->name);
    snprintf(out->driver, sizeof(out->driver), "%s", info->driver);
    snprintf(out->version, sizeof(out->version), "%s", info->version);
    snprintf(out->type, sizeof(out->type), "%s", info->type);
    snprintf(out->reason, sizeof(out->reason), "%s", info->reason);
}

enum lk_status lk_device_info(struct lk_device_info *out, size_t index)
{
    struct gpu_info info;
    const enum status status = gpu_describe(&info, index);
    if (status == STATUS_OK)
        engine_describe_device(out, &info);
    return (enum lk_status)status;
}

// ---- Rendering

static char *copy_text(const char *text)
{
    return text != NULL ? strdup(text) : NULL;
}

// What a kernel traced, or moved where every path moves the same.
static void count_work(struct lk_kernel_time *kernel, const struct lk_render_info *info)
{
    if (strcmp(kernel->name, "trace") == 0)
        kernel->rays = info->rays_camera + info->rays_indirect;
    else if (strcmp(kernel->name, "direct") == 0)
        kernel->rays = info->rays_shadow - info->rays_directional;
    else if (strcmp(kernel->name, "directional") == 0)
        kernel->rays = info->rays_directional;
    else if (strcmp(kernel->name, "raygen") == 0)
        kernel->bytes = info->paths * (sizeof(struct ray) + sizeof(struct path) + sizeof(uint32_t));
}

// Adds a device's kernel times to those of the same names.
static void add_profile(struct lk_render_info *info, const struct gpu *gpu)
{
    struct profile_entry entries[LK_KERNELS_MAX];
    const size_t count = gpu_profile(gpu, entries, LK_KERNELS_MAX);
    for (size_t i = 0; i < count; i++) {
        uint32_t k = 0;
        while (k < info->kernel_count && strcmp(info->kernels[k].name, entries[i].name) != 0)
            k++;
        if (k == LK_KERNELS_MAX)
            continue;
        info->kernel_count = k == info->kernel_count ? k + 1 : info->kernel_count;
        info->kernels[k].calls += entries[i].calls;
        info->kernels[k].time_s += entries[i].time_s;
        memcpy(info->kernels[k].name, entries[i].name, sizeof(info->kernels[k].name));
    }
}

// Makes the image of what has been rendered.
static enum status take_image(struct lk_image **out, const struct render *render,
                              struct lk_render_info *info)
{
    const struct canvas *canvas = &render->canvas;
    struct lk_image *image = calloc(1, sizeof(*image));
    if (image != NULL)
        image->rgb = calloc((size_t)canvas->width * canvas->height, 3 * sizeof(float));
    if (image == NULL || image->rgb == NULL) {
        free(image);
        return status_fail(STATUS_NO_MEMORY, "no memory for an image of %u x %u", canvas->width,
                           canvas->height);
    }
    canvas_resolve(canvas, image->rgb);
    for (size_t i = 0; i < render->renderer_count; i++)
        add_profile(info, &render->renderers[i].gpu);
    for (uint32_t k = 0; k < info->kernel_count; k++)
        count_work(&info->kernels[k], info);
    info->time_s.total = clock_seconds() - render->start_s + info->time_s.import;
    image->width = canvas->width;
    image->height = canvas->height;
    image->rendered = true;
    image->info = *info;
    image->info.scene.file = copy_text(info->scene.file);
    image->info.settings.camera = copy_text(info->settings.camera);
    image->info.settings.device = copy_text(info->settings.device);
    image->info.settings.env = copy_text(info->settings.env);
    *out = image;
    return STATUS_OK;
}

// Chooses and opens the devices. Each GPU is fed by a core of the host, which a CPU among them
// leaves alone.
static enum status open_devices(struct render *render)
{
    struct gpu_info infos[LK_DEVICES_MAX];
    const struct lk_settings *settings = &render->info->settings;
    size_t count = 0;
    enum status status = gpu_select(infos, &count, LK_DEVICES_MAX, settings->device);
    if (status != STATUS_OK)
        return status;
    uint32_t gpu_count = 0;
    for (size_t i = 0; i < count; i++)
        gpu_count += !infos[i].is_cpu;
    render->renderers = calloc(count, sizeof(*render->renderers));
    if (render->renderers == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu devices", count);
    for (size_t i = 0; i < count && status == STATUS_OK; i++) {
        status = renderer_open(&render->renderers[i], &infos[i], settings,
                               infos[i].is_cpu ? gpu_count : 0);
        render->renderer_count += status == STATUS_OK;
    }
    return status;
}

// Plans what each device takes, and makes the canvas.
static enum status plan(struct render *render, const struct camera *camera)
{
    struct lk_render_info *info = render->info;
    const struct lk_settings settings = info->settings; // as asked for
    enum status status = canvas_create(&render->canvas, camera->width, camera->height);
    for (size_t i = 0; i < render->renderer_count && status == STATUS_OK; i++) {
        struct renderer *r = &render->renderers[i];
        struct lk_scene_info described;
        r->camera = *camera;
        r->chosen.width = camera->width;
        r->chosen.height = camera->height;
        if (settings.queue == 0 && r->choice.fusion == FUSION_PATHS &&
            r->chosen.bvh == LK_BVH_WIDE &&
            render->scene->prepared.wide.block_count <= WIDE_FEW_BLOCKS)
            r->chosen.queue = SETTINGS_QUEUE_PATHS;
        if (choice_has_layouts(&r->choice) &&
            !plan_fits(&r->chosen, render->scene, choice_layouts(&r->choice), camera, &r->gpu.info))
            renderer_narrow(r, &settings, render->scene);
        status = plan_memory(&described, &r->chosen, render->scene, choice_layouts(&r->choice),
                             camera, &r->gpu.info);
        if (status != STATUS_OK)
            return status;
        info->scene = i == 0 ? described : info->scene;
        struct lk_device_share *share = &info->devices[info->device_count++];
        engine_describe_device(&share->info, &r->gpu.info);
        share->textures = r->chosen.textures;
        share->queue = r->chosen.queue;
        share->memory = described.memory.total_device;
    }
    info->settings = render->renderers[0].chosen;
    info->device = info->devices[0].info;
    return status;
}

// Everything up to what each device does for itself.
static enum status begin(struct render *render, struct lk_scene *scene)
{
    struct lk_settings *settings = &render->info->settings;
    struct lk_progress progress = {.stage = "preparing", .remaining_s = -1.0};
    struct camera camera;
    unsigned layouts = 0;
    enum status status = settings_check(settings);
    settings_choose_sampler(settings);
    if (status == STATUS_OK)
        status = render_report(render->hook, &progress);
    if (status == STATUS_OK)
        status = open_devices(render);
    if (status == STATUS_OK)
        status = prepare_geometry(scene);
    for (size_t i = 0; i < render->renderer_count && status == STATUS_OK; i++) {
        struct renderer *r = &render->renderers[i];
        if (!choice_fuse(&r->choice, &r->gpu, scene, &r->chosen))
            choice_recall(&r->choice, &r->gpu, scene, settings);
        layouts |= choice_layouts(&r->choice);
    }
    if (status == STATUS_OK)
        status = prepare_scene(scene, settings, layouts);
    if (status == STATUS_OK)
        status = camera_build(&camera, &scene->scene, &scene->prepared.geometry, settings->camera,
                              settings->width, settings->height);
    if (status == STATUS_OK)
        status = plan(render, &camera);
    if (status != STATUS_OK)
        return status;
    render->info->time_s.import = scene->import_s;
    render->info->time_s.prepare = prepared_seconds(scene);
    progress.stage = "building kernels";
    progress.elapsed_s = clock_seconds() - render->start_s;
    return render_report(render->hook, &progress);
}

// A picture of nothing but black is asked for by nobody.
static void warn_of_darkness(const struct lk_scene *scene, const struct lk_scene_info *info)
{
    const struct lk_lights *lights = &info->lights;
    bool dark = lights->drawn + lights->directional + lights->emissive_triangles == 0 &&
                scene->surroundings.environment.map.width == 0;
    for (uint32_t i = 0; i < scene->scene.material_count; i++)
        dark = dark && !scene->scene.materials[i].unlit;
    if (dark)
        log_message(
            LOG_WARNING,
            "%s has no light: the picture is black; --sky, --env or --background bring some",
            info->file);
}

enum lk_status lk_render(struct lk_image **out, struct lk_scene *scene,
                         const struct lk_settings *settings, const struct lk_progress_hook *hook)
{
    struct lk_render_info info = {.settings = *settings};
    struct render render = {
        .scene = scene, .info = &info, .hook = hook, .start_s = clock_seconds()};
    *out = NULL;

    enum status status = begin(&render, scene);
    if (status == STATUS_OK)
        warn_of_darkness(scene, &info.scene);
    if (status == STATUS_OK)
        status = render_paths(&render);
    if (status == STATUS_OK || (status == STATUS_CANCELLED && info.paths > 0)) {
        const enum status taken = take_image(out, &render, &info);
        status = taken != STATUS_OK ? taken : status;
    }
    render_free(&render);
    return (enum lk_status)status;
}
