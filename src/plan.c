#include "plan.h"

#include <sys/resource.h>

#include "core/log.h"
#include "film/film.h"
#include "pipeline/wavefront.h"
#include "prepare.h"
#include "shared/ray.h"

#define QUEUE_MIN 1024u // paths; below it launches cost more than they do
// Log2 of the points of a block: 1024 are 340 KB for a depth of 5.
#define POINT_SHIFT 10u

struct settings plan_kernel_settings(const struct lk_settings *s)
{
    const struct settings out = {
        .seed = s->seed,
        .depth = s->quantity == LK_DIRECT ? 1 : s->depth,
        .shadow_rays = s->shadow_rays,
        .roulette_depth = s->roulette_depth,
        .quantity = s->quantity == LK_IRRADIANCE ? QUANTITY_IRRADIANCE : QUANTITY_RADIANCE,
        .point_shift = s->sampler == LK_SAMPLER_SOBOL ? POINT_SHIFT : 0,
    };
    return out;
}

static void describe(struct lk_scene_info *out, const struct lk_scene *scene,
                     const struct lk_settings *settings, unsigned layouts,
                     const struct camera *camera, uint64_t capacity)
{
    const struct prepared *p = &scene->prepared;
    const struct upload_source source = prepared_source(scene, layouts);
    const struct upload_sizes sizes = upload_sizes(&source);
    const struct settings told = plan_kernel_settings(settings);
    const bool textures_bound = settings->textures == LK_TEXTURES_BOUND;
    const uint64_t pixels = (uint64_t)camera->width * camera->height;
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
                   .rays = capacity * wavefront_path_size(textures_bound),
                   .samples = wavefront_points_size(&told) + wavefront_places_size(pixels),
                   .film = pixels * film_pixel_size(),
                   .peak_host = (uint64_t)usage.ru_maxrss * 1024},
        .width = camera->width,
        .height = camera->height,
    };
    if (textures_bound) // the pool for alpha and emission, and an image of each
        out->memory.materials += p->materials.texel_count * sizeof(*p->materials.texels);
    struct lk_memory *memory = &out->memory;
    memory->total_device = memory->bvh + memory->geometry + memory->materials + memory->lights +
                           memory->rays + memory->samples + memory->film;
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

void plan_describe(struct lk_scene_info *out, const struct lk_scene *scene,
                   const struct lk_settings *settings, unsigned layouts,
                   const struct camera *camera, uint32_t default_queue)
{
    describe(out, scene, settings, layouts, camera,
             queue_capacity(settings, camera, default_queue));
}

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
        {"samples", memory->samples},
        {"film", memory->film},
    };
    const int count = sizeof(users) / sizeof(users[0]);
    for (int i = 0; i < 3; i++)
        for (int j = i + 1; j < count; j++)
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

// The queue that is asked for, as far as one allocation reaches.
static uint64_t whole_queue(const struct lk_settings *settings, const struct camera *camera,
                            const struct gpu_info *info)
{
    const uint64_t capacity = queue_capacity(settings, camera, settings->queue);
    const uint64_t longest = info->max_allocation / sizeof(struct ray);
    return capacity < longest ? capacity : longest;
}

bool plan_fits(const struct lk_settings *settings, const struct lk_scene *scene, unsigned layouts,
               const struct camera *camera, const struct gpu_info *info)
{
    struct lk_scene_info described;
    describe(&described, scene, settings, layouts, camera, whole_queue(settings, camera, info));
    return described.memory.total_device <= settings->memory_limit;
}

enum status plan_memory(struct lk_scene_info *out, struct lk_settings *settings,
                        const struct lk_scene *scene, unsigned layouts, const struct camera *camera,
                        const struct gpu_info *info)
{
    uint64_t capacity = whole_queue(settings, camera, info);
    describe(out, scene, settings, layouts, camera, capacity);
    while (out->memory.total_device > settings->memory_limit && capacity > QUEUE_MIN) {
        capacity = capacity / 2 > QUEUE_MIN ? capacity / 2 : QUEUE_MIN;
        describe(out, scene, settings, layouts, camera, capacity);
    }
    if (out->memory.total_device > settings->memory_limit)
        return fail_memory(&out->memory, settings->memory_limit);
    if (capacity < settings->queue && capacity < queue_capacity(settings, camera, UINT32_MAX))
        log_message(LOG_INFO, "the ray queue is %llu paths, to fit the memory",
                    (unsigned long long)capacity);
    settings->queue = (uint32_t)capacity;
    return STATUS_OK;
}
