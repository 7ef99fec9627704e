// The public API's work: scenes, devices, and lk_render(), which is the program on a page.

#include "engine.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>

#include "core/clock.h"
#include "core/log.h"
#include "prep/camera.h"
#include "prep/samples.h"
#include "prepare.h"
#include "render.h"
#include "scene/gltf_import.h"
#include "settings.h"
#include "shared/path.h"
#include "shared/ray.h"

#define QUEUE_MIN 1024u // paths; below it launches cost more than they do
// Log2 of the points of a block: 1024 are 340 KB for a depth of 5.
#define POINT_SHIFT 10u

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

// What the kernels are told of the settings; what they are told of the scene is left 0.
static struct settings kernel_settings(const struct lk_settings *s)
{
    const struct settings out = {
        .seed = s->seed,
        .depth = s->quantity == LK_DIRECT ? 1 : s->depth,
        .shadow_rays = s->shadow_rays,
        .quantity = s->quantity == LK_IRRADIANCE ? QUANTITY_IRRADIANCE : QUANTITY_RADIANCE,
        .point_shift = s->sampler == LK_SAMPLER_SOBOL ? POINT_SHIFT : 0,
    };
    return out;
}

// Counts what a prepared scene holds; rays and film for this camera and queue.
static void describe_scene(struct lk_scene_info *out, const struct lk_scene *scene,
                           const struct camera *camera, const struct settings *settings,
                           uint64_t capacity, bool textures_bound)
{
    const struct prepared *p = &scene->prepared;
    const struct upload_source source = prepared_source(scene);
    const struct upload_sizes sizes = upload_sizes(&source);
    struct rusage usage;
    getrusage(RUSAGE_SELF, &usage);
    *out = (struct lk_scene_info){
        .file = scene->scene.file,
        .triangles = p->geometry.triangle_count,
        .triangles_split = p->reference_count,
        .instances = scene->scene.instance_count,
        .materials = scene->scene.material_count,
        .textures = scene->scene.texture_count,
        .cameras = scene->scene.camera_count,
        .lights = {.point = p->emitters.point_count,
                   .spot = p->emitters.spot_count,
                   .rect = p->emitters.rectangle_count,
                   .disc = p->emitters.disc_count,
                   .directional =
                       p->emitters.directional_count + scene->surroundings.environment.has_sun,
                   .emissive_triangles = p->emitters.emissive_triangles,
                   .drawn = p->emitters.light_count},
        .memory = {.bvh = sizes.bvh,
                   .geometry = sizes.geometry,
                   .materials = sizes.materials,
                   .lights = sizes.lights,
                   .rays = capacity * wavefront_path_size(textures_bound) +
                           wavefront_points_size(settings),
                   .film = (uint64_t)camera->width * camera->height * film_pixel_size(),
                   .peak_host = (uint64_t)usage.ru_maxrss * 1024},
        .width = camera->width,
        .height = camera->height,
    };
    if (textures_bound) // the pool for alpha and emission, and an image of each
        out->memory.materials += p->materials.texel_count * sizeof(*p->materials.texels);
    struct lk_memory *memory = &out->memory;
    memory->total_device = memory->bvh + memory->geometry + memory->materials + memory->lights +
                           memory->rays + memory->film;
}

// The queue asked for, or the default; never larger than the work.
static uint64_t queue_capacity(const struct lk_settings *settings, const struct camera *camera,
                               uint64_t default_capacity)
{
    const uint64_t pixels = (uint64_t)camera->width * camera->height;
    uint64_t capacity = settings->queue > 0 ? settings->queue : default_capacity;
    if (settings->spp > 0 && capacity > pixels * settings->spp)
        capacity = pixels * settings->spp;
    return capacity;
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
        status = prepare_scene(scene, &chosen);
    if (status == STATUS_OK)
        status = camera_build(&camera, &scene->scene, &scene->prepared.geometry, settings->camera,
                              settings->width, settings->height);
    if (status != STATUS_OK)
        return (enum lk_status)status;
    const uint64_t pixels = (uint64_t)camera.width * camera.height;
    const uint64_t capacity = queue_capacity(
        settings, &camera, pixels < SETTINGS_QUEUE_GPU ? pixels : SETTINGS_QUEUE_GPU);
    const struct settings told = kernel_settings(&chosen);
    describe_scene(out, scene, &camera, &told, capacity, settings->textures == LK_TEXTURES_BOUND);
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

// Says what does not fit, naming the three largest users.
static enum status fail_memory(const struct lk_memory *memory, uint64_t limit)
{
    struct user {
        const char *name;
        uint64_t size;
    } users[] = {
        {"BVH", memory->bvh},
        {"geometry", memory->geometry},
        {"materials", memory->materials},
        {"lights", memory->lights},
        {"rays", memory->rays},
        {"film", memory->film},
    };
    for (int i = 0; i < 3; i++)
        for (int j = i + 1; j < 6; j++)
            if (users[j].size > users[i].size) {
                const struct user larger = users[j];
                users[j] = users[i];
                users[i] = larger;
            }
    return status_fail(STATUS_NO_MEMORY,
                       "the render takes %.0f MB of %.0f MB on the device: %s %.0f MB, %s %.0f MB, "
                       "%s %.0f MB",
                       (double)memory->total_device * 1e-6, (double)limit * 1e-6, users[0].name,
                       (double)users[0].size * 1e-6, users[1].name, (double)users[1].size * 1e-6,
                       users[2].name, (double)users[2].size * 1e-6);
}

// Finds the longest queue that fits, and describes the scene with it.
static enum status plan_memory(struct lk_render_info *info, const struct lk_scene *scene,
                               const struct renderer *r)
{
    struct lk_settings *settings = &info->settings;
    const bool bound = settings->textures == LK_TEXTURES_BOUND;
    const struct settings told = kernel_settings(settings);
    uint64_t capacity = queue_capacity(settings, &r->camera, settings->queue);
    const uint64_t longest = r->gpu.info.max_allocation / sizeof(struct ray);
    if (capacity > longest)
        capacity = longest;
    describe_scene(&info->scene, scene, &r->camera, &told, capacity, bound);
    while (info->scene.memory.total_device > settings->memory_limit && capacity > QUEUE_MIN) {
        capacity = capacity / 2 > QUEUE_MIN ? capacity / 2 : QUEUE_MIN;
        describe_scene(&info->scene, scene, &r->camera, &told, capacity, bound);
    }
    if (info->scene.memory.total_device > settings->memory_limit)
        return fail_memory(&info->scene.memory, settings->memory_limit);
    if (capacity < settings->queue && capacity < queue_capacity(settings, &r->camera, UINT32_MAX))
        log_message(LOG_INFO, "the ray queue is %llu paths, to fit the memory",
                    (unsigned long long)capacity);
    settings->queue = (uint32_t)capacity;
    return STATUS_OK;
}

// Makes the points of samples, and the buffers of the paths in flight.
static enum status create_wavefront(struct renderer *r, const struct lk_settings *settings)
{
    uint4 *points = NULL;
    enum status status =
        samples_build(&points, settings->seed, r->settings.depth, r->settings.point_shift);
    if (status == STATUS_OK)
        status = wavefront_create(&r->wavefront, &r->gpu, settings->queue, &r->settings, &r->camera,
                                  points, settings->textures == LK_TEXTURES_BOUND);
    free(points);
    return status;
}

// Uploads the scene, builds the kernels and makes the buffers.
static enum status set_up(struct renderer *r, struct lk_render_info *info,
                          const struct lk_scene *scene)
{
    const struct lk_settings *settings = &info->settings;
    const struct upload_source source = prepared_source(scene);
    struct program_options options = settings_program_options(settings);
    double start = clock_seconds();
    enum status status =
        upload(&r->scene, &r->gpu, &source, options.nodes_image, options.textures_bound);
    if (status != STATUS_OK)
        return status;
    r->settings = kernel_settings(settings);
    r->settings.light_count = r->scene.light_count;
    r->settings.directional_count = r->scene.directional_count;
    r->settings.material_count = r->scene.material_count;
    r->settings.triangle_count = scene->prepared.geometry.triangle_count;
    r->settings.emitter_count = r->scene.emitter_count;
    status = create_wavefront(r, settings);
    info->time_s.upload = clock_seconds() - start;

    start = clock_seconds();
    options.alpha = r->scene.alpha;
    options.environment = r->scene.map.width > 0;
    options.normal_maps = r->scene.normal_maps;
    options.layers = r->scene.layers;
    options.sheen = r->scene.sheen;
    if (status == STATUS_OK)
        status = pipeline_build(&r->pipeline, &r->gpu, &r->scene, &options);
    if (status == STATUS_OK)
        status = film_create(&r->film, &r->gpu, r->camera.width, r->camera.height, &options);
    info->time_s.kernel_build = clock_seconds() - start;
    info->kernels_from_source = r->pipeline.built + r->film.built;
    return status;
}

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

// Makes the image of what has been rendered.
static enum status take_image(struct lk_image **out, struct renderer *r,
                              struct lk_render_info *info)
{
    struct lk_image *image = calloc(1, sizeof(*image));
    if (image != NULL)
        image->rgb = calloc((size_t)r->camera.width * r->camera.height, 3 * sizeof(float));
    if (image == NULL || image->rgb == NULL) {
        free(image);
        return status_fail(STATUS_NO_MEMORY, "no memory for an image of %u x %u", r->camera.width,
                           r->camera.height);
    }
    const enum status status = film_resolve(&r->film, &r->gpu, image->rgb, &r->sequence);
    if (status != STATUS_OK) {
        lk_image_free(image);
        return status;
    }
    struct profile_entry entries[LK_KERNELS_MAX];
    info->kernel_count = (uint32_t)gpu_profile(&r->gpu, entries, LK_KERNELS_MAX);
    for (uint32_t i = 0; i < info->kernel_count; i++) {
        info->kernels[i].calls = entries[i].calls;
        info->kernels[i].time_s = entries[i].time_s;
        memcpy(info->kernels[i].name, entries[i].name, sizeof(info->kernels[i].name));
        count_work(&info->kernels[i], info);
    }
    info->time_s.total = clock_seconds() - r->start_s + info->time_s.import;
    image->width = r->camera.width;
    image->height = r->camera.height;
    image->rendered = true;
    image->info = *info;
    image->info.scene.file = copy_text(info->scene.file);
    image->info.settings.camera = copy_text(info->settings.camera);
    image->info.settings.device = copy_text(info->settings.device);
    image->info.settings.env = copy_text(info->settings.env);
    *out = image;
    return STATUS_OK;
}

// Everything up to the first ray.
static enum status begin(struct renderer *r, struct lk_render_info *info, struct lk_scene *scene,
                         const struct lk_progress_hook *hook)
{
    struct lk_settings *settings = &info->settings;
    struct lk_progress progress = {.stage = "preparing", .remaining_s = -1.0};
    enum status status = settings_check(settings);
    settings_choose_sampler(settings);
    if (status == STATUS_OK)
        status = render_report(hook, &progress);
    if (status == STATUS_OK)
        status = gpu_open(&r->gpu, settings->device, settings->profile);
    if (status != STATUS_OK)
        return status;
    engine_describe_device(&info->device, &r->gpu.info);
    settings_choose_variants(settings, &r->gpu.info);
    status = settings_check_device(settings, &r->gpu);
    if (status == STATUS_OK)
        status = prepare_scene(scene, settings);
    if (status == STATUS_OK)
        status = camera_build(&r->camera, &scene->scene, &scene->prepared.geometry,
                              settings->camera, settings->width, settings->height);
    if (status != STATUS_OK)
        return status;

    settings->width = r->camera.width;
    settings->height = r->camera.height;
    info->time_s.import = scene->import_s;
    info->time_s.prepare = prepared_seconds(scene);
    progress.stage = "building kernels";
    progress.elapsed_s = clock_seconds() - r->start_s;
    status = plan_memory(info, scene, r);
    if (status == STATUS_OK)
        status = render_report(hook, &progress);
    if (status == STATUS_OK)
        status = set_up(r, info, scene);
    return status;
}

enum lk_status lk_render(struct lk_image **out, struct lk_scene *scene,
                         const struct lk_settings *settings, const struct lk_progress_hook *hook)
{
    struct renderer renderer = {.start_s = clock_seconds()};
    struct lk_render_info info = {.settings = *settings};
    *out = NULL;

    enum status status = begin(&renderer, &info, scene, hook);
    if (status == STATUS_OK)
        status = render_paths(&renderer, &info, hook);
    if (status == STATUS_OK ||
        (status == STATUS_CANCELLED && sequence_paths(&renderer.sequence) > 0)) {
        const enum status taken = take_image(out, &renderer, &info);
        status = taken != STATUS_OK ? taken : status;
    }
    renderer_free(&renderer);
    return (enum lk_status)status;
}
