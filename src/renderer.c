#include "renderer.h"

#include <math.h>
#include <stdlib.h>

#include "core/clock.h"
#include "plan.h"
#include "prep/samples.h"
#include "prepare.h"
#include "settings.h"
#include "shared/light.h"

#define BATCH_SECONDS 0.15   // aim for one batch: no launch in it can last longer
#define FIRST_PATHS   1024u  // paths of the first batch: it finds out how fast the device is,
#define FIRST_RAYS    65536u // with at most so many shadow rays of a bounce
#define PATHS_MIN     32u    // least batch, for hits that look at thousands of lights
#define PATHS_STEP    1024u  // batches are whole tiles of the Z-order, for coherence

enum status renderer_open(struct renderer *out, const struct gpu_info *info,
                          const struct lk_settings *settings, uint32_t spare_units)
{
    struct renderer r = {.chosen = *settings};
    enum status status = gpu_open(&r.gpu, info, settings->profile, spare_units);
    if (status != STATUS_OK)
        return status;
    settings_choose_variants(&r.chosen, &r.gpu);
    status = settings_check_device(&r.chosen, &r.gpu);
    if (status != STATUS_OK) {
        renderer_free(&r);
        return status;
    }
    *out = r;
    return STATUS_OK;
}

// Makes the points of samples, and the buffers of the paths in flight.
static enum status create_wavefront(struct renderer *r)
{
    uint4 *points = NULL;
    enum status status =
        samples_build(&points, r->settings.seed, r->settings.depth, r->settings.point_shift);
    if (status == STATUS_OK)
        status = wavefront_create(&r->wavefront, &r->gpu, r->chosen.queue, &r->settings, &r->camera,
                                  points, r->chosen.textures == LK_TEXTURES_BOUND);
    free(points);
    if (status != STATUS_OK)
        return status;
    r->counters = calloc(r->wavefront.bounce_count, sizeof(*r->counters));
    return r->counters != NULL ? STATUS_OK
                               : status_fail(STATUS_NO_MEMORY, "no memory for counters");
}

// The size of the first batch: small, so that a slow device is found out before a launch is long.
static uint32_t first_batch(const struct renderer *r)
{
    uint32_t rays = r->settings.shadow_rays;
    if (r->chosen.light_sampler == LK_LIGHTS_ALL)
        rays = r->settings.light_count;
    else if (r->chosen.light_sampler == LK_LIGHTS_IMPORTANCE)
        rays *= LIGHT_WALK_MOST;
    uint32_t paths = rays > FIRST_RAYS / FIRST_PATHS ? FIRST_RAYS / rays : FIRST_PATHS;
    paths = paths < PATHS_MIN ? PATHS_MIN : paths;
    return paths < r->wavefront.capacity ? paths : r->wavefront.capacity;
}

enum status renderer_set_up(struct renderer *r, const struct lk_scene *scene)
{
    const struct upload_source source = prepared_source(scene, r->chosen.bvh);
    struct program_options options = settings_program_options(&r->chosen);
    double start = clock_seconds();
    enum status status =
        upload(&r->scene, &r->gpu, &source, options.nodes_image, options.textures_bound);
    if (status != STATUS_OK)
        return status;
    r->settings = plan_kernel_settings(&r->chosen);
    r->settings.light_count = r->scene.light_count;
    r->settings.directional_count = r->scene.directional_count;
    r->settings.material_count = r->scene.material_count;
    r->settings.triangle_count = scene->prepared.geometry.triangle_count;
    r->settings.emitter_count = r->scene.emitter_count;
    status = create_wavefront(r);
    r->batch_paths = first_batch(r);
    r->upload_s = clock_seconds() - start;

    start = clock_seconds();
    options.alpha = r->scene.alpha;
    options.environment = r->scene.map.width > 0;
    options.normal_maps = r->scene.normal_maps;
    options.layers = r->scene.layers;
    options.sheen = r->scene.sheen;
    if (status == STATUS_OK)
        status = pipeline_build(&r->pipeline, &r->gpu, &r->scene, &options);
    if (status == STATUS_OK)
        status = film_create(&r->film, &r->gpu, r->camera.width * r->camera.height, &options);
    r->build_s = clock_seconds() - start;
    r->built = r->pipeline.built + r->film.built;
    return status;
}

// Sets the size of the next batch by how long one of so many paths took.
static void adapt(struct renderer *r, uint32_t count, double seconds)
{
    const double ratio = seconds > 0.0 ? BATCH_SECONDS / seconds : 2.0;
    const double most = 4.0 * r->batch_paths;
    double paths = fmin(count * ratio, most);
    if (count < r->batch_paths) // cut short, it shows less than the device can
        paths = fmax(paths, r->batch_paths);
    paths = fmin(fmax(paths, PATHS_MIN), r->wavefront.capacity);
    const uint32_t whole = (uint32_t)paths / PATHS_STEP * PATHS_STEP;
    r->batch_paths = whole > 0 ? whole : (uint32_t)paths;
    if (r->batch_paths == 0)
        r->batch_paths = 1;
}

enum status renderer_batch(struct renderer *r, struct sequence *sequence, bool tells)
{
    const double begin = clock_seconds();
    const struct batch batch = sequence_batch(sequence, r->batch_paths);
    enum status status = pipeline_enqueue(&r->pipeline, &r->gpu, &r->scene, &r->wavefront, &batch,
                                          r->settings.depth);
    if (status == STATUS_OK)
        status = film_enqueue(&r->film, &r->gpu, &r->wavefront, &batch);
    if (status == STATUS_OK)
        status = buffer_read(&r->gpu, &r->wavefront.counters, r->counters,
                             r->wavefront.bounce_count * sizeof(*r->counters));
    if (status != STATUS_OK)
        return status;

    sequence_advance(sequence, &batch);
    r->rays.camera += batch.count;
    for (uint32_t i = 0; i < r->wavefront.bounce_count; i++) {
        r->rays.indirect += i > 0 ? r->counters[i].active : 0;
        r->rays.shadow += r->counters[i].shadow_rays + r->counters[i].directional_rays;
        r->rays.directional += r->counters[i].directional_rays;
    }
    if (tells)
        adapt(r, batch.count, clock_seconds() - begin);
    return STATUS_OK;
}

void renderer_free(struct renderer *r)
{
    free(r->counters);
    film_free(&r->gpu, &r->film);
    pipeline_free(&r->pipeline);
    wavefront_free(&r->gpu, &r->wavefront);
    device_scene_free(&r->gpu, &r->scene);
    gpu_close(&r->gpu);
    *r = (struct renderer){0};
}
