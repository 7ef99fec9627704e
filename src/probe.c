#include "probe.h"

#include <math.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/choices.h"
#include "core/clock.h"
#include "core/log.h"
#include "shared/ray.h"

#define GROWTH   8u     // of the batches
#define REPEATS  4u     // of the largest
#define BOUNCES  3u     // a camera's, the first, and a later one
#define CHECKED  16384u // slots whose hits and light are compared
#define BETTER   0.98 // of the rule's time: what is nearer may be noise, which is 0.5 % on an H100
#define NAME_MAX 96

struct probe_limits probe_limits = {.all = 0.3, .launch = 2.0, .grace = 8.0, .telling = 1e-4};

// What slots hold: of some, for comparison.
struct checked {
    struct hit hits[CHECKED];
    struct path paths[CHECKED];
};

typedef double seconds_table[RAY_CLASSES][PIPELINE_FORMS_MAX];

struct probe {
    struct renderer *r;
    struct choice *choice;
    struct checked *first;     // of the first form
    struct checked *now, *old; // of the form at hand; before it
    bool checks;               // in this batch
    bool stuck;
    bool struck[PIPELINE_FORMS_MAX];
    seconds_table batch; // taken in this batch,
    seconds_table least; // and in the best of all as large; 0: none
};

// ---- Striking out

__attribute__((format(printf, 3, 4))) static void strike(struct probe *p, uint32_t form,
                                                         const char *format, ...)
{
    char why[128], name[NAME_MAX];
    va_list list;
    va_start(list, format);
    vsnprintf(why, sizeof(why), format, list);
    va_end(list);
    p->struck[form] = true;
    log_message(LOG_WARNING, "device \"%s\": tracing by %s %s, and is not used",
                p->r->gpu.info.name, form_name(name, sizeof(name), &p->choice->forms[form]), why);
}

static bool is_near(float a, float b, float tolerance)
{
    return fabsf(a - b) <= tolerance * (fabsf(a) + fabsf(b)) + 1e-6f;
}

// Hits that differ by more than rounding does: at an edge a ray may meet either neighbour.
static uint32_t count_other_hits(const struct hit *a, const struct hit *b, uint32_t count)
{
    uint32_t others = 0;
    for (uint32_t i = 0; i < count; i++) {
        const bool missed = a[i].triangle == HIT_NONE;
        others += a[i].triangle != b[i].triangle || (!missed && !is_near(a[i].t, b[i].t, 1e-4f));
    }
    return others;
}

static uint32_t count_other_light(const struct path *a, const struct path *b, uint32_t count)
{
    uint32_t others = 0;
    for (uint32_t i = 0; i < count; i++) {
        const float4 x = a[i].radiance_normal;
        const float4 y = b[i].radiance_normal;
        others +=
            !is_near(x.x, y.x, 1e-3f) || !is_near(x.y, y.y, 1e-3f) || !is_near(x.z, y.z, 1e-3f);
    }
    return others;
}

static bool is_in(const struct probe *p, uint32_t form, bool shadows)
{
    const struct pipeline_form *built = &p->r->pipeline.forms[form];
    return !p->struck[form] && !built->failed && (shadows ? built->shadows : built->traces);
}

// Reads what a form has done, and compares it with what the first one did.
static enum status check(struct probe *p, const struct stage_context *context, uint32_t first,
                         uint32_t form, bool shadows)
{
    const struct wavefront *w = context->wavefront;
    const uint32_t count = context->batch.count < CHECKED ? context->batch.count : CHECKED;
    struct checked *read = form == first ? p->first : p->now;
    const enum status status =
        shadows ? buffer_read(&p->r->timed, &w->paths, read->paths, count * sizeof(struct path))
                : buffer_read(&p->r->timed, &w->hits, read->hits, count * sizeof(struct hit));
    if (status != STATUS_OK || form == first)
        return status;
    const uint32_t others = shadows ? count_other_light(read->paths, p->first->paths, count)
                                    : count_other_hits(read->hits, p->first->hits, count);
    const uint32_t rounded = shadows ? count / 100 + 2 : count / 500 + 2; // may be other paths
    const char *what = shadows ? "light" : "hits";
    char name[NAME_MAX];
    if (others <= rounded)
        return STATUS_OK;
    form_name(name, sizeof(name), &p->choice->forms[first]);
    strike(p, form, "gives other %s than %s in %u of %u paths", what, name, others, count);
    if (first > 0) // it may itself be wrong
        strike(p, first, "is all there is to judge that by");
    return STATUS_OK;
}

// ---- Measuring

// Device time of everything so far.
static double kernel_seconds(const struct probe *p)
{
    struct profile_entry entries[LK_KERNELS_MAX];
    const size_t count = gpu_profile(&p->r->timed, entries, LK_KERNELS_MAX);
    double seconds = 0.0;
    for (size_t i = 0; i < count; i++)
        seconds += entries[i].time_s;
    return seconds;
}

static enum status read_counters(struct probe *p)
{
    struct renderer *r = p->r;
    return buffer_read(&r->timed, &r->wavefront.counters, r->counters,
                       r->wavefront.bounce_count * sizeof(*r->counters));
}

// Traces a bounce's rays, or shadow rays, by one form, and waits for it.
static enum status launch(struct probe *p, const struct stage_context *context, uint32_t form,
                          bool shadows, double *seconds)
{
    const struct renderer *r = p->r;
    const double before_s = kernel_seconds(p);
    bool done = true;
    enum status status = buffer_write(&p->r->timed, &r->wavefront.counters, r->counters,
                                      r->wavefront.bounce_count * sizeof(*r->counters));
    if (status == STATUS_OK)
        status = shadows ? pipeline_light(&r->pipeline, form, context)
                         : pipeline_trace(&r->pipeline, form, context);
    if (status == STATUS_OK)
        status = gpu_wait_until(&p->r->timed, probe_limits.launch, &done);
    if (status == STATUS_OK && !done) {
        strike(p, form, "takes longer than %g s", probe_limits.launch);
        status = gpu_wait_until(&p->r->timed, probe_limits.grace, &done);
    }
    p->stuck = !done;
    if (status == STATUS_OK && p->stuck)
        return status_fail(STATUS_DEVICE, "device \"%s\" does not end a launch",
                           p->r->gpu.info.name);
    if (status == STATUS_OK)
        *seconds += kernel_seconds(p) - before_s;
    return status;
}

// Lets all forms do the same. What the last of them has done goes on, unless it is struck out.
static enum status try_forms(struct probe *p, const struct stage_context *context,
                             enum ray_class class)
{
    const struct wavefront *w = context->wavefront;
    const bool shadows = class == RAYS_SHADOW;
    const uint32_t count = context->batch.count < CHECKED ? context->batch.count : CHECKED;
    const size_t paths_size = count * sizeof(struct path);
    const bool restores = p->checks && shadows; // light adds up
    uint32_t first = 0;                         // form of these
    bool struck = false;
    enum status status = read_counters(p);
    while (first + 1 < p->choice->form_count && !is_in(p, first, shadows))
        first++;
    if (status == STATUS_OK && restores)
        status = buffer_read(&p->r->timed, &w->paths, p->old->paths, paths_size);
    for (uint32_t i = 0; i < p->choice->form_count && status == STATUS_OK; i++) {
        if (!is_in(p, i, shadows))
            continue;
        if (restores)
            status = buffer_write(&p->r->timed, &w->paths, p->old->paths, paths_size);
        if (status == STATUS_OK)
            status = launch(p, context, i, shadows, &p->batch[class][i]);
        if (status == STATUS_OK && p->checks)
            status = check(p, context, first, i, shadows);
        struck = struck || p->struck[i];
    }
    double unused = 0.0;
    if (status == STATUS_OK && struck && is_in(p, first, shadows))
        status = launch(p, context, first, shadows, &unused);
    return status;
}

// One bounce. Sets *alive to whether rays go on.
static enum status try_bounce(struct probe *p, const struct stage_context *context,
                              uint32_t bounces, bool *alive)
{
    const struct pipeline *pipeline = &p->r->pipeline;
    enum status status = read_counters(p);
    *alive = status == STATUS_OK && p->r->counters[context->bounce].active > 0;
    if (!*alive)
        return status;
    status = try_forms(p, context, pipeline_class(context->bounce));
    if (status == STATUS_OK)
        status = pipeline_shade(pipeline, context);
    if (status == STATUS_OK && context->bounce < p->r->settings.depth &&
        pipeline_has_shadows(context->scene))
        status = try_forms(p, context, RAYS_SHADOW);
    *alive = context->bounce + 1 < bounces;
    if (status == STATUS_OK && *alive)
        status = pipeline_go_on(pipeline, context);
    return status;
}

static enum status try_batch(struct probe *p, uint32_t paths)
{
    struct renderer *r = p->r;
    const struct span whole = {.pixel_count = r->camera.width * r->camera.height,
                               .end_sample = UINT64_MAX};
    struct sequence sequence;
    sequence_begin(&sequence, &whole, false);
    struct stage_context context = {
        .gpu = &p->r->timed,
        .scene = &r->scene,
        .wavefront = &r->wavefront,
        .batch = sequence_batch(&sequence, paths),
        .coherent = true,
    };
    uint32_t bounces = pipeline_bounces(&r->scene, r->settings.depth);
    bounces = bounces < BOUNCES ? bounces : BOUNCES;
    memset(p->batch, 0, sizeof(p->batch));
    bool alive = true;
    enum status status = raygen_enqueue(&r->pipeline.raygen, &context);
    for (; status == STATUS_OK && alive && !p->struck[0]; context.bounce++) {
        status = try_bounce(p, &context, bounces, &alive);
        context.coherent = false;
    }
    return status;
}

// Takes a batch's times over; those of smaller ones are forgotten.
static void keep_times(struct probe *p, bool larger)
{
    for (int c = 0; c < RAY_CLASSES; c++)
        for (uint32_t i = 0; i < p->choice->form_count; i++) {
            const double old = larger ? 0.0 : p->least[c][i];
            const double now = p->batch[c][i];
            p->least[c][i] = old > 0.0 && old < now ? old : now;
        }
}

// Tries larger and larger batches, then the largest again, for as long as there is time. A batch
// takes at most as much longer than the one before as it is larger.
static enum status measure(struct probe *p, double start_s)
{
    const uint32_t most = p->r->wavefront.capacity;
    uint32_t count = p->r->batch_paths;
    uint32_t last = 0;
    uint32_t repeats = 0;
    double end_s = start_s;
    enum status status = STATUS_OK;
    do {
        const double begin_s = clock_seconds();
        p->checks = count > last;
        status = try_batch(p, count);
        if (status != STATUS_OK || p->struck[0])
            return status;
        keep_times(p, count > last);
        repeats += count == last;
        last = count;
        count = most / GROWTH > count ? count * GROWTH : most;
        end_s = clock_seconds() + (clock_seconds() - begin_s) * count / last;
    } while (end_s <= start_s + probe_limits.all && repeats < REPEATS);
    return STATUS_OK;
}

// ---- Deciding

// Takes the fastest form for rays of a kind, if it is clearly faster than the rule's.
static void decide_class(struct probe *p, enum ray_class class)
{
    struct choice *choice = p->choice;
    const double *seconds = p->least[class];
    const bool shadows = class == RAYS_SHADOW;
    const bool rule_works = is_in(p, choice->of[class], shadows);
    double most = 0.0; // of all forms
    double least = rule_works ? BETTER * seconds[choice->of[class]] : INFINITY;
    uint32_t best = choice->of[class];
    bool found = rule_works;
    for (uint32_t i = 0; i < choice->form_count; i++) {
        char name[NAME_MAX];
        if (!is_in(p, i, shadows) || !(seconds[i] > 0.0))
            continue;
        log_message(LOG_DEBUG, "probe: %s rays by %s in %.3f ms", choices_rays[class],
                    form_name(name, sizeof(name), &choice->forms[i]), seconds[i] * 1e3);
        most = fmax(most, seconds[i]);
        if (seconds[i] < least) {
            least = seconds[i];
            best = i;
            found = true;
        }
    }
    choice->broken = choice->broken || !found;
    if (most > 0.0 && most >= probe_limits.telling) {
        choice->of[class] = best;
        choice->reasons[class] = LK_REASON_PROBE;
    } else if (!rule_works && found) {
        choice->of[class] = best;
    }
}

static uint32_t count_shadow_forms(const struct choice *choice)
{
    uint32_t count = 0;
    for (uint32_t i = 0; i < choice->form_count; i++)
        count += (choice->forms[i].uses & FORM_SHADOWS) != 0;
    return count;
}

static enum status run(struct renderer *r, bool *stuck)
{
    struct probe *p = calloc(1, sizeof(*p));
    struct checked *checked = calloc(3, sizeof(*checked));
    const double start_s = clock_seconds();
    enum status status = STATUS_NO_MEMORY;
    if (p == NULL || checked == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for a probe");
        goto cleanup;
    }
    p->r = r;
    p->choice = &r->choice;
    p->first = &checked[0];
    p->now = &checked[1];
    p->old = &checked[2];
    status = gpu_wait(&r->gpu); // what was written there is to be read here
    if (status == STATUS_OK)
        status = gpu_open_timed(&p->r->timed, &r->gpu);
    if (status != STATUS_OK)
        goto cleanup;
    status = measure(p, start_s);
    *stuck = p->stuck || status == STATUS_DEVICE; // a driver may have ended what did not
    if (!*stuck)
        gpu_close_timed(&r->timed);
    for (int c = 0; c < RAY_CLASSES && status == STATUS_OK; c++)
        decide_class(p, (enum ray_class)c);
    if (status == STATUS_OK && !p->struck[0] && count_shadow_forms(p->choice) == 1)
        choice_follow(p->choice);
    r->choice.open = false;
    r->choice.probe_s = clock_seconds() - start_s;

cleanup:
    free(checked);
    free(p);
    return status;
}

static bool has_found(const struct choice *choice)
{
    for (int c = 0; c < RAY_CLASSES; c++)
        if (choice->reasons[c] == LK_REASON_PROBE)
            return true;
    return false;
}

enum status probe_decide(struct renderer *r, bool *stuck)
{
    static pthread_mutex_t turn = PTHREAD_MUTEX_INITIALIZER;
    enum status status = STATUS_OK;
    *stuck = false;
    pthread_mutex_lock(&turn);
    if (!choice_recall_again(&r->choice, r->chosen.no_cache)) {
        status = run(r, stuck);
        if (status == STATUS_OK && has_found(&r->choice))
            choice_keep(&r->choice, r->chosen.no_cache);
    }
    pthread_mutex_unlock(&turn);
    return status;
}
