#include "render.h"

#include <math.h>
#include <stdlib.h>

#include "core/clock.h"
#include "plan.h"
#include "share.h"

#define PROGRESS_EVERY 0.1 // seconds between calls of the hook

enum status render_report(const struct lk_progress_hook *hook, const struct lk_progress *progress)
{
    if (hook == NULL || hook->function == NULL || hook->function(hook->user, progress))
        return STATUS_OK;
    return status_fail(STATUS_CANCELLED, "cancelled while %s", progress->stage);
}

enum status render_progress(const struct render *render, const struct render_state *state)
{
    const struct lk_settings *settings = &render->info->settings;
    const uint64_t pixels = (uint64_t)render->canvas.width * render->canvas.height;
    const double total = settings->spp > 0 ? (double)settings->spp * (double)pixels : INFINITY;
    const double limit_s = settings->time_s;
    const double seconds = state->seconds;
    const double by_paths = (double)state->paths / total;
    const double by_time = limit_s > 0.0 ? fmin(seconds / limit_s, 1.0) : 0.0;
    // Paths go with the inverse square of the error.
    const double by_noise =
        state->noise > 0.0 ? fmin(pow(settings->noise / state->noise, 2.0), 1.0) : 0.0;
    double remaining = -1.0;
    if (isfinite(total) && state->timed_paths > 0)
        remaining = (total - (double)state->paths) * seconds / (double)state->timed_paths;
    if (by_noise > 0.0 && (remaining < 0.0 || seconds / by_noise - seconds < remaining))
        remaining = seconds / by_noise - seconds;
    if (limit_s > 0.0 && (remaining < 0.0 || limit_s - seconds < remaining))
        remaining = fmax(limit_s - seconds, 0.0);
    const struct ray_counts *rays = &state->rays;
    const double share = state->paths > 0 ? (double)state->timed_paths / (double)state->paths : 0.0;
    const struct lk_progress progress = {
        .stage = "rendering",
        .fraction = fmax(fmax(by_paths, by_noise), by_time),
        .elapsed_s = clock_seconds() - render->start_s,
        .remaining_s = remaining,
        .spp = (double)state->paths / (double)pixels,
        .mrays_per_s = seconds > 0.0 ? (double)(rays->camera + rays->indirect + rays->shadow) *
                                           share / seconds * 1e-6
                                     : 0.0,
    };
    return render_report(render->hook, &progress);
}

// Goes from batch to batch until a limit is met.
static enum status render_batches(struct render *render, struct sequence *sequence)
{
    struct lk_render_info *info = render->info;
    struct renderer *r = &render->renderers[0];

    // The first batch counts as building.
    const double begin = clock_seconds();
    enum status status = renderer_batch(r, sequence, false);
    const double start = clock_seconds();
    r->build_s += start - begin;

    const double limit_s = info->settings.time_s;
    double next_report = 0.0;
    struct render_state state = {.paths = sequence_paths(sequence)};
    const uint64_t untimed = state.paths;
    while (status == STATUS_OK && !sequence_ended(sequence) &&
           !(limit_s > 0.0 && state.seconds >= limit_s)) {
        status = renderer_batch(r, sequence, true);
        if (status != STATUS_OK)
            return status;
        const double now = clock_seconds();
        state.seconds = now - start;
        state.paths = sequence_paths(sequence);
        state.timed_paths = state.paths - untimed;
        state.rays = r->rays;
        if (now < next_report && !sequence_ended(sequence))
            continue;
        next_report = now + PROGRESS_EVERY;
        status = render_progress(render, &state);
    }
    info->time_s.render = clock_seconds() - start;
    return status;
}

// The whole picture on one device.
static enum status render_alone(struct render *render)
{
    struct renderer *r = &render->renderers[0];
    const uint32_t spp = render->info->settings.spp;
    const struct span whole = {
        .pixel_count = render->canvas.width * render->canvas.height,
        .end_sample = spp > 0 ? spp : UINT64_MAX,
    };
    struct sequence sequence;
    sequence_begin(&sequence, &whole, true);
    enum status status = renderer_set_up(r, render->scene);
    if (status == STATUS_OK)
        status = film_begin(&r->film, &r->gpu, &render->canvas, &whole);
    if (status != STATUS_OK)
        return status;
    status = render_batches(render, &sequence);
    if (status != STATUS_OK && status != STATUS_CANCELLED)
        return status;
    const enum status ended = film_end(&r->film, &r->gpu, &render->canvas, &sequence);
    return ended != STATUS_OK ? ended : status;
}

// Tells how a device traced, and what it holds for that.
static void tell_tracing(struct render *render, size_t index)
{
    struct lk_render_info *info = render->info;
    struct lk_device_share *share = &info->devices[index];
    struct renderer *r = &render->renderers[index];
    const struct choice *choice = &r->choice;
    struct lk_scene_info described;
    for (int c = 0; c < LK_RAYS_COUNT; c++)
        share->tracing[c] = (struct lk_tracing){.trace = choice->forms[choice->of[c]].trace,
                                                .bvh = choice->forms[choice->of[c]].bvh,
                                                .reason = choice->reasons[c]};
    share->trace = share->tracing[LK_RAYS_LATER_BOUNCES].trace;
    share->bvh = share->tracing[LK_RAYS_LATER_BOUNCES].bvh;
    share->probe_s = choice->probe_s;
    share->fused = r->pipeline.fusion != FUSION_NONE;
    plan_describe(&described, render->scene, &r->chosen, choice_layouts(choice), &r->camera,
                  r->chosen.queue);
    share->memory = described.memory.total_device;
    if (index > 0)
        return;
    info->scene.memory = described.memory;
    info->settings.trace = share->trace;
    info->settings.bvh = share->bvh;
}

// Adds up what the devices did.
static void count_work(struct render *render)
{
    struct lk_render_info *info = render->info;
    for (size_t i = 0; i < render->renderer_count; i++) {
        const struct renderer *r = &render->renderers[i];
        tell_tracing(render, i);
        info->rays_camera += r->rays.camera;
        info->rays_indirect += r->rays.indirect;
        info->rays_shadow += r->rays.shadow;
        info->rays_directional += r->rays.directional;
        info->kernels_from_source += r->built;
        info->time_s.upload = fmax(info->time_s.upload, r->upload_s);
        info->time_s.kernel_build = fmax(info->time_s.kernel_build, r->build_s);
        info->devices[i].paths = r->rays.camera;
        info->devices[i].busy_s =
            r->busy_s > 0.0 || render->renderer_count > 1 ? r->busy_s : info->time_s.render;
    }
    info->paths = canvas_paths(&render->canvas);
    info->spp =
        (double)info->paths / ((double)render->canvas.width * (double)render->canvas.height);
}

enum status render_paths(struct render *render)
{
    render->info->noise = -1.0;
    const bool in_rounds = render->renderer_count > 1 || render->info->settings.noise > 0.0f;
    const enum status status = in_rounds ? share_paths(render) : render_alone(render);
    count_work(render);
    return status;
}

void render_free(struct render *render)
{
    for (size_t i = 0; i < render->renderer_count; i++)
        renderer_free(&render->renderers[i]);
    free(render->renderers);
    canvas_free(&render->canvas);
    *render = (struct render){0};
}
