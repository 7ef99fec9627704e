#include "share.h"

#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

#include "core/clock.h"
#include "film/noise.h"

#define SPAN_SECONDS_MAX  1.0        // a device takes no more at a time: its speed may change
#define SPAN_SECONDS_MIN  0.008      // nor less, so that launches and copies are worth their while
#define ROUND_SECONDS_MAX 10.0       // a cancelled render has pixels that are up to a round apart
#define ROUND_SECONDS_MIN 0.5        // the end of a round costs some milliseconds
#define PROGRESS_EVERY    0.1        // seconds between calls of the hook
#define WARM_UP_SECONDS   0.004      // of a batch that tells a speed: launches take a part of it
#define WARM_UP_BATCHES   8          // each has up to four times as many paths as the one before
#define SAMPLES_MAX       (1u << 24) // where nothing else ends them
#define PIXELS_STEP       64u        // spans are whole tiles of the Z-order, for coherence

struct worker {
    struct share *share;
    struct renderer *renderer;
    pthread_t thread;
    double rate;            // paths a second, 0 until it is ready
    struct ray_counts rays; // finished
};

struct share {
    struct render *render;
    struct worker *workers; // [render->renderer_count]
    pthread_mutex_t lock;   // of all below, and of rate and rays above
    pthread_cond_t changed; // spans may be had that could not before, or it is over
    struct span round;      // what is dealt out,
    uint32_t next_pixel;    // from here on
    uint32_t held;          // spans that are worked on
    struct noise noise;     // empty unless an error was asked for
    double start_s;         // when the first device was ready; 0: none is
    double end_s;           // when the last span was given back
    bool over;              // everything is done, or no more is to be
    enum status status;     // of the first failure,
    char message[2048];     // and its words
};

static double total_rate(const struct share *s)
{
    double total = 0.0;
    for (size_t i = 0; i < s->render->renderer_count; i++)
        total += s->workers[i].rate;
    return total;
}

static double fastest_rate(const struct share *s)
{
    double fastest = 0.0;
    for (size_t i = 0; i < s->render->renderer_count; i++)
        fastest = fmax(fastest, s->workers[i].rate);
    return fastest;
}

// ---- Dealing out; all of this under the lock

// Ends the render; `where` is NULL or the device that failed.
static void end(struct share *s, enum status status, const struct renderer *where)
{
    if (s->status == STATUS_OK && status != STATUS_OK) {
        s->status = status;
        snprintf(s->message, sizeof(s->message), "%s%s%s%s", where != NULL ? "device \"" : "",
                 where != NULL ? where->gpu.info.name : "", where != NULL ? "\": " : "",
                 status_message());
    }
    s->over = true;
    pthread_cond_broadcast(&s->changed);
}

// Decides on the samples that all pixels take in the next round: first one, so that a cancelled
// render has something of every pixel. False if none are left.
static bool next_samples(struct share *s)
{
    const struct lk_settings *settings = &s->render->info->settings;
    struct span *round = &s->round;
    round->first_sample = round->end_sample;
    const uint64_t left = settings->spp > 0 ? settings->spp - round->first_sample : UINT64_MAX;
    if (left == 0)
        return false;
    const double per_second = total_rate(s) / round->pixel_count;
    double samples = fmax((double)round->first_sample, per_second * ROUND_SECONDS_MIN);
    samples = fmin(samples, per_second * ROUND_SECONDS_MAX);
    if (settings->time_s > 0.0)
        samples = fmin(samples, per_second * (s->start_s + settings->time_s - clock_seconds()));
    uint64_t count = samples > 1.0 && round->first_sample > 0 ? (uint64_t)samples : 1;
    if (count >= 32)
        count -= count % 16; // whole passes
    if (count > left || (count > 1 && left - count < count / 4))
        count = left;
    round->end_sample = round->first_sample + count;
    return true;
}

// Begins the next round, or ends the render.
static void begin_round(struct share *s)
{
    const struct lk_settings *settings = &s->render->info->settings;
    const uint64_t most = settings->spp > 0 ? settings->spp : SAMPLES_MAX;
    s->next_pixel = 0;
    const bool goes_on = settings->noise > 0.0f
                             ? noise_next(&s->noise, &s->render->canvas, most, &s->round)
                             : next_samples(s);
    if (goes_on)
        pthread_cond_broadcast(&s->changed);
    else
        end(s, STATUS_OK, NULL);
}

// How many pixels a device is to take now.
static uint32_t span_pixels(const struct share *s, const struct worker *w)
{
    const double total = total_rate(s);
    const double per_second =
        w->rate / (double)(s->round.end_sample - s->round.first_sample); // of its pixels
    const double left = s->round.pixel_count - s->next_pixel;
    const double least = fmax(per_second * SPAN_SECONDS_MIN, 1.0);
    const double rest_s = left / per_second * w->rate / total; // all devices take for the rest
    if (w->rate < fastest_rate(s) && least / per_second > rest_s)
        return 0;
    double pixels = fmin(0.5 * left * w->rate / total, per_second * SPAN_SECONDS_MAX);
    pixels = fmin(fmax(pixels, least), left);
    const uint32_t whole = (uint32_t)pixels / PIXELS_STEP * PIXELS_STEP;
    return whole > 0 ? whole : (uint32_t)ceil(pixels);
}

// Takes a span, waiting for one if need be. False when it is over.
static bool take_span(struct worker *w, struct span *out)
{
    struct share *s = w->share;
    uint32_t pixels = 0;
    pthread_mutex_lock(&s->lock);
    while (!s->over && (s->next_pixel == s->round.pixel_count || (pixels = span_pixels(s, w)) == 0))
        pthread_cond_wait(&s->changed, &s->lock);
    const bool taken = !s->over;
    if (taken) {
        *out = s->round;
        out->first_pixel = s->next_pixel;
        out->pixel_count = pixels;
        if (out->places != NULL)
            out->places += s->next_pixel;
        s->next_pixel += pixels;
        s->held++;
    }
    pthread_mutex_unlock(&s->lock);
    return taken;
}

// Gives a span back; every waiting device looks anew, since speeds have changed.
static void give_span(struct worker *w, uint64_t paths, double seconds, enum status status)
{
    struct share *s = w->share;
    pthread_mutex_lock(&s->lock);
    // The first spans tell too little of a device: what is faster is believed at once.
    if (seconds > 0.0 && paths > 0)
        w->rate = fmax((double)paths / seconds, 0.5 * (w->rate + (double)paths / seconds));
    w->renderer->busy_s += seconds;
    s->end_s = clock_seconds();
    s->held--;
    if (status != STATUS_OK)
        end(s, status, w->renderer);
    else if (!s->over && s->next_pixel == s->round.pixel_count && s->held == 0)
        begin_round(s);
    pthread_cond_broadcast(&s->changed);
    pthread_mutex_unlock(&s->lock);
}

// ---- A device's thread

// Counts a finished batch. False when it is over.
static bool count_batch(struct worker *w)
{
    struct share *s = w->share;
    pthread_mutex_lock(&s->lock);
    w->rays = w->renderer->rays;
    const bool over = s->over;
    pthread_mutex_unlock(&s->lock);
    return !over;
}

static void render_span(struct worker *w, const struct span *span)
{
    struct renderer *r = w->renderer;
    struct canvas *canvas = &w->share->render->canvas;
    const double begin = clock_seconds();
    struct sequence sequence;
    sequence_begin(&sequence, span, false);
    enum status status = film_begin(&r->film, &r->gpu, canvas, span);
    if (status == STATUS_OK && span->places != NULL)
        status = wavefront_set_places(&r->wavefront, &r->gpu, span->places, span->pixel_count);
    bool goes_on = true;
    while (status == STATUS_OK && goes_on && !sequence_ended(&sequence)) {
        status = renderer_batch(r, &sequence, true);
        goes_on = count_batch(w);
    }
    if (status == STATUS_OK)
        status = film_end(&r->film, &r->gpu, canvas, &sequence);
    give_span(w, sequence_paths(&sequence), clock_seconds() - begin, status);
}

// Batches that nobody sees: the first waits for kernels that are compiled when first launched, the
// others grow until their time tells how fast the device is.
static enum status warm_up(struct worker *w)
{
    struct share *s = w->share;
    struct renderer *r = w->renderer;
    const struct span span = {.pixel_count = r->camera.width * r->camera.height,
                              .end_sample = SAMPLES_MAX};
    const double start = clock_seconds();
    double rate = 0.0;
    enum status status = film_begin(&r->film, &r->gpu, &s->render->canvas, &span);
    for (int i = 0; i < WARM_UP_BATCHES && status == STATUS_OK; i++) {
        struct sequence sequence;
        sequence_begin(&sequence, &span, false);
        const double begin = clock_seconds();
        status = renderer_batch(r, &sequence, i > 0);
        const double seconds = fmax(clock_seconds() - begin, 1e-6);
        rate = (double)sequence_paths(&sequence) / seconds;
        if (i > 0 && seconds > WARM_UP_SECONDS)
            break;
    }
    r->build_s += clock_seconds() - start;
    r->rays = (struct ray_counts){0};
    if (status != STATUS_OK)
        return status;

    // Who is ready first begins.
    pthread_mutex_lock(&s->lock);
    w->rate = rate;
    if (s->start_s == 0.0) {
        s->start_s = clock_seconds();
        begin_round(s);
    }
    pthread_cond_broadcast(&s->changed);
    pthread_mutex_unlock(&s->lock);
    return STATUS_OK;
}

static void *work(void *user)
{
    struct worker *w = user;
    struct span span;
    enum status status = renderer_set_up(w->renderer, w->share->render->scene);
    if (status == STATUS_OK)
        status = warm_up(w);
    if (status != STATUS_OK) {
        pthread_mutex_lock(&w->share->lock);
        end(w->share, status, w->renderer);
        pthread_mutex_unlock(&w->share->lock);
        return NULL;
    }
    while (take_span(w, &span))
        render_span(w, &span);
    return NULL;
}

// ---- The caller's thread

static struct render_state state_of(const struct share *s)
{
    struct render_state state = {.seconds = s->start_s > 0.0 ? clock_seconds() - s->start_s : 0.0};
    for (size_t i = 0; i < s->render->renderer_count; i++) {
        const struct ray_counts *rays = &s->workers[i].rays;
        state.rays.camera += rays->camera;
        state.rays.indirect += rays->indirect;
        state.rays.shadow += rays->shadow;
    }
    state.paths = state.timed_paths = state.rays.camera;
    state.noise = s->noise.reached;
    return state;
}

static enum status report(const struct share *s, const struct render_state *state)
{
    if (state->paths > 0)
        return render_progress(s->render, state);
    const struct lk_progress progress = {.stage = "building kernels",
                                         .elapsed_s = clock_seconds() - s->render->start_s,
                                         .remaining_s = -1.0};
    return render_report(s->render->hook, &progress);
}

// Tells the hook, and ends the render when it says so or the time is up.
static void watch(struct share *s)
{
    const double limit_s = s->render->info->settings.time_s;
    double next_report = clock_seconds() + PROGRESS_EVERY;
    pthread_mutex_lock(&s->lock);
    while (!s->over) {
        const bool limited = limit_s > 0.0 && s->start_s > 0.0;
        const double until_s = limited ? fmin(next_report, s->start_s + limit_s) : next_report;
        const struct timespec until = {.tv_sec = (time_t)until_s,
                                       .tv_nsec = (long)((until_s - floor(until_s)) * 1e9)};
        pthread_cond_timedwait(&s->changed, &s->lock, &until);
        const double now = clock_seconds();
        if (limited && now >= s->start_s + limit_s)
            end(s, STATUS_OK, NULL);
        if (s->over || now < next_report)
            continue;
        next_report = now + PROGRESS_EVERY;
        const struct render_state state = state_of(s);
        pthread_mutex_unlock(&s->lock);
        const enum status status = report(s, &state);
        pthread_mutex_lock(&s->lock);
        if (status != STATUS_OK)
            end(s, status, NULL);
    }
    pthread_mutex_unlock(&s->lock);
}

static enum status run_workers(struct share *s)
{
    size_t started = 0;
    for (; started < s->render->renderer_count; started++) {
        struct worker *w = &s->workers[started];
        w->share = s;
        w->renderer = &s->render->renderers[started];
        if (pthread_create(&w->thread, NULL, work, w) != 0)
            break;
    }
    if (started < s->render->renderer_count) {
        pthread_mutex_lock(&s->lock);
        end(s, status_fail(STATUS_NO_MEMORY, "no thread for a device"), NULL);
        pthread_mutex_unlock(&s->lock);
    }
    watch(s);
    for (size_t i = 0; i < started; i++)
        pthread_join(s->workers[i].thread, NULL);
    return s->status == STATUS_OK ? STATUS_OK : status_fail(s->status, "%s", s->message);
}

enum status share_paths(struct render *render)
{
    struct share share = {
        .render = render,
        .workers = calloc(render->renderer_count, sizeof(*share.workers)),
        .round = {.pixel_count = render->canvas.width * render->canvas.height},
    };
    if (share.workers == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu devices", render->renderer_count);
    const double asked = render->info->settings.noise;
    enum status status = STATUS_OK;
    if (asked > 0.0)
        status = noise_create(&share.noise, share.round.pixel_count, asked);
    if (status != STATUS_OK) {
        free(share.workers);
        return status;
    }
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&share.changed, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_init(&share.lock, NULL);

    status = run_workers(&share);
    render->info->time_s.render = fmax(share.end_s - share.start_s, 0.0);
    if (status == STATUS_OK) {
        const struct render_state state = state_of(&share);
        status = report(&share, &state);
    }
    if (asked > 0.0)
        render->info->noise = noise_estimate(&share.noise, &render->canvas);
    noise_free(&share.noise);
    pthread_mutex_destroy(&share.lock);
    pthread_cond_destroy(&share.changed);
    free(share.workers);
    return status;
}
