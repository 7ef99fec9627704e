// The public API's rays: a scene's triangles on a device, without materials.

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "engine.h"
#include "pipeline/stages.h"
#include "prep/bvh_visits.h"
#include "prep/camera.h"
#include "prep/samples.h"
#include "prepare.h"
#include "settings.h"
#include "shared/ray.h"

_Static_assert(sizeof(struct lk_ray) == sizeof(struct ray), "rays are copied as they are");
_Static_assert(sizeof(struct lk_hit) == sizeof(struct hit), "hits are copied as they are");
_Static_assert(LK_HIT_NONE == HIT_NONE, "hits are copied as they are");

// Launch i stands for bounce 2 i of a path, which reads the same queue as bounce 0.
#define BOUNCES (2u * LK_LAUNCHES_MAX)

#define COHERENT_RUN 256u // rays from one point, on average, that count as a camera's: many packets

struct lk_tracer {
    struct gpu gpu;
    struct device_scene scene; // BVH only
    struct wavefront wavefront;
    struct raygen raygen;
    struct trace nearest, any;
    struct camera camera;
    struct lk_tracer_info info;
    uint32_t ray_count; // rays set
    bool coherent;      // neighbours come from one point
};

enum lk_status lk_scene_geometry(struct lk_geometry *out, struct lk_scene *scene)
{
    const enum status status = prepare_geometry(scene);
    if (status != STATUS_OK)
        return (enum lk_status)status;
    const struct geometry *geometry = &scene->prepared.geometry;
    *out = (struct lk_geometry){
        .positions = (const float *)geometry->vertices,
        .corners = (const uint32_t *)geometry->triangles,
        .position_stride = sizeof(*geometry->vertices) / sizeof(float),
        .corner_stride = sizeof(*geometry->triangles) / sizeof(uint32_t),
        .vertex_count = geometry->vertex_count,
        .triangle_count = geometry->triangle_count,
    };
    return LK_OK;
}

// Where the middle of a light is.
static void find_middle(float *place, const struct emitters *emitters, size_t index)
{
    const struct light *light = &emitters->lights[index];
    uint32_t kind;
    memcpy(&kind, &light->color_kind.w, sizeof(kind));
    const enum light_type type = kind & LIGHT_TYPE_MASK;
    const float share = type == LIGHT_TRIANGLE    ? 1.0f / 3.0f
                        : type == LIGHT_RECTANGLE ? 0.5f
                                                  : 0.0f;
    memcpy(place, &light->org_range, 3 * sizeof(*place));
    if (share > 0.0f) {
        const struct light_shape *shape = &emitters->shapes[kind >> LIGHT_SHAPE_SHIFT];
        place[0] += share * (shape->edge_u.x + shape->edge_v.x);
        place[1] += share * (shape->edge_u.y + shape->edge_v.y);
        place[2] += share * (shape->edge_u.z + shape->edge_v.z);
    }
    place[3] = 1.0f;
}

bool lk_scene_light(float place[4], const struct lk_scene *scene, size_t index)
{
    const struct emitters *emitters = &scene->prepared.emitters;
    if (index < emitters->light_count) {
        find_middle(place, emitters, index);
        return true;
    }
    index -= emitters->light_count;
    if (index >= emitters->directional_count)
        return false;
    const float4 dir = emitters->directional[index].dir;
    place[0] = -dir.x;
    place[1] = -dir.y;
    place[2] = -dir.z;
    place[3] = 0.0f;
    return true;
}

enum lk_status lk_scene_visits(struct lk_visits *out, struct lk_scene *scene,
                               const struct lk_settings *settings, const struct lk_ray *rays,
                               uint32_t count, uint32_t step, bool any_hit)
{
    if (step == 0)
        return (enum lk_status)status_fail(STATUS_USAGE,
                                           "every 0th ray is none: step is 1 at least");
    struct lk_settings plain = *settings;
    plain.light_sampler = LK_LIGHTS_UNIFORM; // needs no preparation
    const enum status status = prepare_scene(scene, &plain, 1u << LK_BVH_BINARY);
    if (status != STATUS_OK)
        return (enum lk_status)status;
    struct bvh_visits sum = {0};
    uint32_t looked_at = 0;
    for (uint32_t i = 0; i < count; i += step) {
        struct ray ray;
        memcpy(&ray, &rays[i], sizeof(ray));
        bvh_count_visits(&sum, &scene->prepared.bvh, &ray, any_hit);
        looked_at++;
    }
    const double share = looked_at > 0 ? 1.0 / looked_at : 0.0;
    *out = (struct lk_visits){share * (double)sum.nodes, share * (double)sum.references};
    return LK_OK;
}

// Uploads the BVH alone.
static enum status upload_solid(struct lk_tracer *t, const struct lk_scene *scene, bool nodes_image)
{
    static const struct geometry no_geometry;
    static const struct emitters no_emitters;
    static const struct environment no_environment;
    static const struct light_tree no_tree;
    static const struct light_bvh no_bvh;
    static const struct material_set no_materials;
    const struct upload_source prepared = prepared_source(scene, 1u << t->info.settings.bvh);
    const struct upload_source source = {
        .geometry = &no_geometry,
        .bvh = prepared.bvh,
        .wide = prepared.wide,
        .quad = prepared.quad,
        .layouts = prepared.layouts,
        .compressed = prepared.compressed,
        .emitters = &no_emitters,
        .environment = &no_environment,
        .light_tree = &no_tree,
        .light_bvh = &no_bvh,
        .materials = &no_materials,
    };
    t->info.bvh_size = upload_sizes(&source).bvh;
    return upload(&t->scene, &t->gpu, &source, nodes_image, false);
}

static enum status set_up(struct lk_tracer *t, struct lk_scene *scene)
{
    const struct lk_settings *s = &t->info.settings;
    const struct settings settings = {.seed = s->seed, .depth = BOUNCES};
    struct program_options options = settings_program_options(s);
    uint32_t built = 0;
    options.ray_spans = true;
    uint4 *points = NULL; // random: point_shift is 0
    enum status status = samples_build(&points, s->seed, BOUNCES, settings.point_shift);
    if (status == STATUS_OK)
        status = upload_solid(t, scene, options.nodes_image);
    if (status == STATUS_OK)
        status = wavefront_create(&t->wavefront, &t->gpu, t->info.width * t->info.height, &settings,
                                  &t->camera, points, false);
    free(points);
    if (status == STATUS_OK)
        status = raygen_build(&t->raygen, &t->gpu, &options, &built);
    if (status == STATUS_OK)
        status = trace_build(&t->nearest, &t->gpu, &options, &built);
    options.any_hit = true;
    if (status == STATUS_OK)
        status = trace_build(&t->any, &t->gpu, &options, &built);
    return status;
}

// Everything up to the first ray.
static enum status begin(struct lk_tracer *t, struct lk_scene *scene)
{
    struct lk_settings *settings = &t->info.settings;
    struct gpu_info device;
    size_t device_count = 0;
    settings->light_sampler = LK_LIGHTS_UNIFORM; // needs no preparation
    enum status status = settings_check(settings);
    if (status == STATUS_OK)
        status = gpu_select(&device, &device_count, 1, settings->device);
    if (status == STATUS_OK)
        status = gpu_open(&t->gpu, &device, false, 0);
    if (status != STATUS_OK)
        return status;
    settings_choose_variants(settings, &t->gpu);
    engine_describe_device(&t->info.device, &t->gpu.info);
    status = settings_check_device(settings, &t->gpu);
    if (status == STATUS_OK)
        status = prepare_scene(scene, settings, 1u << settings->bvh);
    if (status == STATUS_OK)
        status = camera_build(&t->camera, &scene->scene, &scene->prepared.geometry,
                              settings->camera, settings->width, settings->height);
    if (status != STATUS_OK)
        return status;
    t->info.width = t->camera.width;
    t->info.height = t->camera.height;
    t->info.references = scene->prepared.reference_count;
    t->info.build_s = scene->prepared.bvh_s;
    return set_up(t, scene);
}

enum lk_status lk_tracer_create(struct lk_tracer **out, struct lk_scene *scene,
                                const struct lk_settings *settings)
{
    struct lk_tracer *tracer = calloc(1, sizeof(*tracer));
    if (tracer == NULL)
        return (enum lk_status)status_fail(STATUS_NO_MEMORY, "no memory for a tracer");
    tracer->info.settings = *settings;
    const enum status status = begin(tracer, scene);
    if (status != STATUS_OK) {
        lk_tracer_free(tracer);
        return (enum lk_status)status;
    }
    *out = tracer;
    return LK_OK;
}

void lk_tracer_free(struct lk_tracer *tracer)
{
    if (tracer == NULL)
        return;
    trace_free(&tracer->any);
    trace_free(&tracer->nearest);
    raygen_free(&tracer->raygen);
    wavefront_free(&tracer->gpu, &tracer->wavefront);
    device_scene_free(&tracer->gpu, &tracer->scene);
    gpu_close(&tracer->gpu);
    free(tracer);
}

const struct lk_tracer_info *lk_tracer_info(const struct lk_tracer *tracer)
{
    return &tracer->info;
}

static struct stage_context make_context(struct lk_tracer *t, uint32_t count)
{
    const struct stage_context context = {
        .gpu = &t->gpu,
        .scene = &t->scene,
        .wavefront = &t->wavefront,
        .batch = {.count = count, .pixel_count = t->info.width * t->info.height},
        .coherent = t->coherent,
    };
    return context;
}

enum lk_status lk_tracer_camera_rays(struct lk_tracer *tracer, struct lk_ray *rays)
{
    const uint32_t count = tracer->info.width * tracer->info.height;
    const struct stage_context context = make_context(tracer, count);
    enum status status = raygen_enqueue(&tracer->raygen, &context);
    if (status == STATUS_OK)
        status =
            buffer_read(&tracer->gpu, &tracer->wavefront.rays, rays, count * sizeof(struct ray));
    return (enum lk_status)status;
}

// Whether runs of rays come from one point, as those of cameras do.
static bool share_origins(const struct lk_ray *rays, uint32_t count)
{
    uint32_t changes = 0;
    for (uint32_t i = 1; i < count; i++)
        changes += memcmp(rays[i].org, rays[i - 1].org, sizeof(rays[0].org)) != 0;
    return changes <= count / COHERENT_RUN;
}

enum lk_status lk_tracer_set_rays(struct lk_tracer *tracer, const struct lk_ray *rays,
                                  uint32_t count)
{
    if (count > tracer->info.width * tracer->info.height)
        return (enum lk_status)status_fail(STATUS_USAGE, "%u rays are more than %u x %u", count,
                                           tracer->info.width, tracer->info.height);

    // Camera rays bring the queue with them.
    const struct stage_context context = make_context(tracer, count);
    enum status status = raygen_enqueue(&tracer->raygen, &context);
    if (status == STATUS_OK)
        status =
            buffer_write(&tracer->gpu, &tracer->wavefront.rays, rays, count * sizeof(struct ray));
    tracer->ray_count = count;
    tracer->coherent = share_origins(rays, count);
    return (enum lk_status)status;
}

enum lk_status lk_tracer_run(struct lk_tracer *tracer, double *seconds, bool any_hit,
                             uint32_t launches)
{
    struct counters counters[BOUNCES];
    struct gpu *gpu = &tracer->gpu;
    const struct buffer *counted = &tracer->wavefront.counters;
    const struct trace *trace = any_hit ? &tracer->any : &tracer->nearest;
    if (launches < 1 || launches > LK_LAUNCHES_MAX)
        return (enum lk_status)status_fail(STATUS_USAGE, "%u launches are not within 1 .. %u",
                                           launches, LK_LAUNCHES_MAX);
    memset(counters, 0, sizeof(counters));
    for (uint32_t i = 0; i < BOUNCES; i++)
        counters[i].active = tracer->ray_count;
    enum status status = buffer_write(gpu, counted, counters, sizeof(counters));

    const double start = clock_seconds();
    struct stage_context context = make_context(tracer, tracer->ray_count);
    for (uint32_t i = 0; i < launches && status == STATUS_OK; i++) {
        context.bounce = 2 * i;
        status = trace_enqueue(trace, &context);
    }
    if (status == STATUS_OK) // waits for what comes before
        status = buffer_read(gpu, counted, counters, sizeof(counters[0]));
    if (seconds != NULL)
        *seconds = (clock_seconds() - start) / launches;
    return (enum lk_status)status;
}

enum lk_status lk_tracer_hits(struct lk_tracer *tracer, struct lk_hit *hits)
{
    return (enum lk_status)buffer_read(&tracer->gpu, &tracer->wavefront.hits, hits,
                                       tracer->ray_count * sizeof(struct hit));
}
