#include "render.h"

#include <math.h>
#include <stdlib.h>

#include "core/clock.h"

#define BATCH_SECONDS  0.15   // aim for one batch: no launch in it can last longer
#define FIRST_PATHS    1024u  // paths of the first batch: it finds out how fast the device is,
#define FIRST_RAYS     65536u // with at most so many shadow rays of a bounce
#define PATHS_MIN      32u    // least batch, for hits that look at thousands of lights
#define PROGRESS_EVERY 0.1    // seconds between calls of the hook
#define PATHS_STEP     1024u  // batches are whole tiles of the Z-order, for coherence

enum status render_report(const struct lk_progress_hook *hook, const struct lk_progress *progress)
{
    if (hook == NULL || hook->function == NULL || hook->function(hook->user, progress))
        return STATUS_OK;
    return status_fail(STATUS_CANCELLED, "cancelled while %s", progress->stage);
}

// Where a render stands.
struct pace {
    uint64_t total;       // paths to do; UINT64_MAX: until the time is up
    uint32_t batch_paths; // of the next batch
    uint64_t paths_timed; // finished since the first batch
    double start_s;       // when the second batch began: the first waits for kernels to be compiled
    double next_report_s;
    struct counters *counters; // [bounce_count] read back after each batch
};

static uint64_t pixel_count(const struct renderer *renderer)
{
    return (uint64_t)renderer->camera.width * renderer->camera.height;
}

// Enqueues one batch, waits for it, and counts its rays.
static enum status render_batch(struct renderer *r, struct lk_render_info *info, struct pace *pace)
{
    const struct batch batch = sequence_batch(&r->sequence, pace->batch_paths);
    enum status status = pipeline_enqueue(&r->pipeline, &r->gpu, &r->scene, &r->wavefront, &batch,
                                          r->settings.depth);
    if (status == STATUS_OK)
        status = film_enqueue(&r->film, &r->gpu, &r->wavefront, &batch);
    if (status == STATUS_OK)
        status = buffer_read(&r->gpu, &r->wavefront.counters, pace->counters,
                             r->wavefront.bounce_count * sizeof(*pace->counters));
    if (status != STATUS_OK)
        return status;

    sequence_advance(&r->sequence, &batch);
    info->rays_camera += batch.count;
    for (uint32_t i = 0; i < r->wavefront.bounce_count; i++) {
        info->rays_indirect += i > 0 ? pace->counters[i].active : 0;
        info->rays_shadow += pace->counters[i].shadow_rays + pace->counters[i].directional_rays;
        info->rays_directional += pace->counters[i].directional_rays;
    }
    return STATUS_OK;
}

// Sets the size of the next batch by how long the last one took.
static void adapt(struct pace *pace, const struct renderer *r, double seconds)
{
    const double ratio = seconds > 0.0 ? BATCH_SECONDS / seconds : 2.0;
    double paths = pace->batch_paths * fmin(ratio, 4.0);
    paths = fmin(fmax(paths, PATHS_MIN), r->wavefront.capacity);
    const uint32_t whole = (uint32_t)paths / PATHS_STEP * PATHS_STEP;
    pace->batch_paths = whole > 0 ? whole : (uint32_t)paths;
    if (pace->batch_paths == 0)
        pace->batch_paths = 1;
}

static enum status report(const struct renderer *r, const struct lk_render_info *info,
                          const struct lk_progress_hook *hook, struct pace *pace)
{
    const double now = clock_seconds();
    if (now < pace->next_report_s && !sequence_ended(&r->sequence))
        return STATUS_OK;
    pace->next_report_s = now + PROGRESS_EVERY;
    const uint64_t paths = sequence_paths(&r->sequence);

    const double seconds = now - pace->start_s;
    const double limit_s = info->settings.time_s;
    const double by_paths = pace->total != UINT64_MAX ? (double)paths / (double)pace->total : 0.0;
    const double by_time = limit_s > 0.0 ? fmin(seconds / limit_s, 1.0) : 0.0;
    double remaining = -1.0;
    if (pace->total != UINT64_MAX && pace->paths_timed > 0)
        remaining = (double)(pace->total - paths) * seconds / (double)pace->paths_timed;
    if (limit_s > 0.0 && (remaining < 0.0 || limit_s - seconds < remaining))
        remaining = fmax(limit_s - seconds, 0.0);
    const uint64_t rays = info->rays_camera + info->rays_indirect + info->rays_shadow;
    const double share = paths > 0 ? (double)pace->paths_timed / (double)paths : 0;
    const struct lk_progress progress = {
        .stage = "rendering",
        .fraction = fmax(by_paths, by_time),
        .elapsed_s = now - r->start_s,
        .remaining_s = remaining,
        .spp = (double)paths / (double)pixel_count(r),
        .mrays_per_s = seconds > 0.0 ? (double)rays * share / seconds * 1e-6 : 0.0,
    };
    return render_report(hook, &progress);
}

// Goes from batch to batch until a limit is met.
static enum status render_batches(struct renderer *r, struct lk_render_info *info,
                                  const struct lk_progress_hook *hook, struct pace *pace)
{
    // The first batch also waits for kernels that are compiled when first launched, as PoCL's are.
    const double begin = clock_seconds();
    enum status status = render_batch(r, info, pace);
    if (status != STATUS_OK)
        return status;
    double last = clock_seconds();
    info->time_s.kernel_build += last - begin;
    pace->start_s = last;

    const double limit_s = info->settings.time_s;
    while (!sequence_ended(&r->sequence) && !(limit_s > 0.0 && last - pace->start_s >= limit_s)) {
        const uint64_t before = sequence_paths(&r->sequence);
        status = render_batch(r, info, pace);
        if (status != STATUS_OK)
            return status;
        const double now = clock_seconds();
        adapt(pace, r, now - last);
        pace->paths_timed += sequence_paths(&r->sequence) - before;
        last = now;
        status = report(r, info, hook, pace);
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

// The size of the first batch: small, so that a slow device is found out before a launch is long.
static uint32_t first_batch(const struct renderer *r, const struct lk_settings *settings)
{
    const uint32_t rays =
        settings->light_sampler == LK_LIGHTS_ALL ? r->settings.light_count : settings->shadow_rays;
    uint32_t paths = rays > FIRST_RAYS / FIRST_PATHS ? FIRST_RAYS / rays : FIRST_PATHS;
    paths = paths < PATHS_MIN ? PATHS_MIN : paths;
    return paths < r->wavefront.capacity ? paths : r->wavefront.capacity;
}

enum status render_paths(struct renderer *renderer, struct lk_render_info *info,
                         const struct lk_progress_hook *hook)
{
    const struct lk_settings *settings = &info->settings;
    struct pace pace = {
        .total = settings->spp > 0 ? settings->spp * pixel_count(renderer) : UINT64_MAX,
        .batch_paths = first_batch(renderer, settings),
        .counters = calloc(renderer->wavefront.bounce_count, sizeof(struct counters)),
    };
    if (pace.counters == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for counters");
    sequence_begin(&renderer->sequence, (uint32_t)pixel_count(renderer), settings->spp);
    const double begin = clock_seconds();
    const double build_s = info->time_s.kernel_build;
    const enum status status = render_batches(renderer, info, hook, &pace);
    info->time_s.render = clock_seconds() - begin - (info->time_s.kernel_build - build_s);
    info->paths = sequence_paths(&renderer->sequence);
    info->spp = (double)info->paths / (double)pixel_count(renderer);
    free(pace.counters);
    return status;
}

void renderer_free(struct renderer *renderer)
{
    film_free(&renderer->gpu, &renderer->film);
    pipeline_free(&renderer->pipeline);
    wavefront_free(&renderer->gpu, &renderer->wavefront);
    device_scene_free(&renderer->gpu, &renderer->scene);
    gpu_close(&renderer->gpu);
}
