#include "renderer.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>
#include <string.h>

#include "core/choices.h"
#include "core/clock.h"
#include "core/log.h"
#include "plan.h"
#include "prep/samples.h"
#include "prepare.h"
#include "probe.h"
#include "settings.h"
#include "shared/light.h"

#define BATCH_SECONDS 0.15   // aim for one batch: no launch in it can last longer
#define RUN_SECONDS   0.02   // of a run of batches,
#define RUN_MAX       8.0    // and how many it has at most: they may turn out to be slow ones
#define FIRST_PATHS   1024u  // paths of the first batch: it finds out how fast the device is,
#define FIRST_RAYS    65536u // with at most so many shadow rays of a bounce
#define PATHS_MIN     32u    // least batch, for hits that look at thousands of lights
#define PATHS_STEP    1024u  // batches are whole tiles of the Z-order, for coherence

// Of an item of the one kernel of a bounce. It would take 96; with 64 an H100 renders the Cornell
// box 10 % faster, with 80 5 %, and with 48 27 % slower.
#define FUSED_REGISTERS 64u

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
    choice_begin(&r.choice, settings, &r.chosen, &r.gpu);
    *out = r;
    return STATUS_OK;
}

void renderer_narrow(struct renderer *r, const struct lk_settings *settings,
                     const struct lk_scene *scene)
{
    struct lk_settings narrowed = *settings;
    narrowed.bvh = r->chosen.bvh;
    choice_begin(&r->choice, &narrowed, &r->chosen, &r->gpu);
    choice_recall(&r->choice, &r->gpu, scene, settings);
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
    r->counters = calloc(2 * r->wavefront.bounce_count, sizeof(*r->counters));
    r->before = r->counters != NULL ? r->counters + r->wavefront.bounce_count : NULL;
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

// Uploads the scene and makes the buffers.
static enum status set_up_memory(struct renderer *r, const struct lk_scene *scene)
{
    const struct upload_source source = prepared_source(scene, choice_layouts(&r->choice));
    const struct program_options options = settings_program_options(&r->chosen);
    const double start = clock_seconds();
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
    r->batch_run = 1;
    r->upload_s = clock_seconds() - start;
    return status;
}

// The variant of the kernels that this scene needs, to trace by one of the forms.
static struct program_options scene_options(const struct renderer *r, const struct form *form)
{
    struct lk_settings chosen = r->chosen;
    chosen.trace = form->trace;
    chosen.bvh = form->bvh;
    struct program_options options = settings_program_options(&chosen);
    options.more = form->more;
    options.alpha = r->scene.alpha;
    options.environment = r->scene.map.width > 0;
    options.no_emitters = r->scene.emitter_count == (uint32_t)(r->scene.map.width > 0);
    options.few_lights = r->scene.few_lights;
    options.untextured = r->scene.untextured;
    options.normal_maps = r->scene.normal_maps;
    options.layers = r->scene.layers;
    options.sheen = r->scene.sheen;
    return options;
}

// Builds the pipeline, with all forms while the choice is open, else with those that are taken.
static enum status build_pipeline(struct renderer *r)
{
    const struct choice *choice = &r->choice;
    const struct form plain = {LK_TRACE_SIMPLE, r->chosen.bvh, 0, NULL};
    const struct program_options options = scene_options(r, &plain);
    struct pipeline_form forms[PIPELINE_FORMS_MAX] = {{.failed = false}};
    for (uint32_t i = 0; i < choice->form_count; i++) {
        const bool is_plain = choice->forms[i].trace == LK_TRACE_SIMPLE;
        forms[i].options = scene_options(r, &choice->forms[i]);
        forms[i].may_fail = !is_plain && choice->reasons[0] != LK_REASON_FORCED;
        forms[i].traces = choice->open && form_has(&choice->forms[i], RAYS_CAMERA);
        forms[i].shadows = choice->open && (choice->forms[i].uses & FORM_SHADOWS) != 0;
    }
    for (int c = 0; c < RAY_CLASSES && !choice->open; c++) {
        forms[choice->of[c]].traces |= c != RAYS_SHADOW;
        forms[choice->of[c]].shadows |= c == RAYS_SHADOW;
    }
    return pipeline_build(&r->pipeline, &r->gpu, &r->scene, &options, forms, choice->form_count,
                          choice->open);
}

static bool is_taken(const struct choice *choice, uint32_t form)
{
    for (int c = 0; c < RAY_CLASSES; c++)
        if (choice->of[c] == form)
            return true;
    return false;
}

static void tell(const struct renderer *r)
{
    const struct choice *choice = &r->choice;
    for (int c = 0; c < RAY_CLASSES; c++) {
        char name[96];
        log_message(LOG_INFO, "device \"%s\": %s rays by %s (%s)", r->gpu.info.name,
                    choices_rays[c], form_name(name, sizeof(name), &choice->forms[choice->of[c]]),
                    choices_reason[choice->reasons[c]]);
    }
}

// Decides how to trace, and releases what is not needed for that.
static enum status settle(struct renderer *r, bool *stuck)
{
    struct choice *choice = &r->choice;
    enum status status = STATUS_OK;
    if (choice->open)
        status = probe_decide(r, stuck);
    bool broken = choice->broken;
    for (int c = 0; c < RAY_CLASSES; c++)
        broken = broken || r->pipeline.forms[choice->of[c]].failed;
    if (status == STATUS_OK && !broken) {
        status = pipeline_add_shadows(&r->pipeline, &r->gpu, &r->scene, choice->of[RAYS_SHADOW]);
        broken = r->pipeline.forms[choice->of[RAYS_SHADOW]].failed;
    }
    if (status == STATUS_OK && broken) {
        pipeline_free(&r->pipeline);
        choice_fall_back(choice);
        status = build_pipeline(r);
    }
    if (status != STATUS_OK)
        return status;
    for (uint32_t i = 0; i < choice->form_count; i++)
        if (!is_taken(choice, i))
            pipeline_drop(&r->pipeline, i);
    for (int c = 0; c < RAY_CLASSES; c++)
        r->pipeline.form_of[c] = choice->of[c];
    device_scene_keep(&r->gpu, &r->scene, choice_layouts(choice));
    tell(r);
    return STATUS_OK;
}

// Builds the pipeline that has one kernel for each bounce, or for whole paths. Returns false, and
// builds nothing, where that is not wanted or cannot be.
static bool fuse(struct renderer *r)
{
    struct choice *choice = &r->choice;
    struct program_options options = scene_options(r, &choice->forms[choice->of[RAYS_CAMERA]]);
    if (!pipeline_can_fuse(choice->fusion, &r->scene, &options))
        return false;
    if (choice->fusion == FUSION_BOUNCES && program_takes_votes(&r->gpu))
        options.registers = FUSED_REGISTERS;
    if (pipeline_build_fused(&r->pipeline, &r->gpu, choice->fusion, &options) != STATUS_OK) {
        log_message(LOG_WARNING, "%s; each stage has its own kernel", status_message());
        choice->fusion = FUSION_NONE;
        return false;
    }
    if (choice->fusion == FUSION_PATHS) {
        log_message(LOG_INFO, "device \"%s\": a path is one kernel (few triangles, all Lambert)",
                    r->gpu.info.name);
    } else {
        log_message(LOG_INFO, "device \"%s\": a bounce is one kernel", r->gpu.info.name);
        tell(r);
    }
    return true;
}

// Forgets what a probe has counted.
static enum status clear_counters(struct renderer *r)
{
    memset(r->counters, 0, 2 * r->wavefront.bounce_count * sizeof(*r->counters));
    return buffer_clear(&r->gpu, &r->wavefront.counters);
}

static enum status set_up(struct renderer *r, const struct lk_scene *scene, bool *stuck)
{
    *stuck = false;
    enum status status = set_up_memory(r, scene);
    if (status != STATUS_OK)
        return status;
    const double start = clock_seconds();
    if (!fuse(r)) {
        status = build_pipeline(r);
        if (status == STATUS_OK)
            status = settle(r, stuck);
    }
    if (status == STATUS_OK)
        status = film_create(&r->film, &r->gpu, r->camera.width * r->camera.height,
                             &r->pipeline.options);
    if (status == STATUS_OK)
        status = clear_counters(r);
    r->build_s = clock_seconds() - start;
    r->built = r->pipeline.built + r->film.built;
    return status;
}

// What devices that hang may still work on. It stays: to release it would be to wait for them.
static struct abandoned {
    struct renderer renderer;
    struct abandoned *next;
} * abandoned;

// Leaves a device that hangs alone and opens it anew, to be used in the plain form.
static enum status start_again(struct renderer *r)
{
    static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
    struct abandoned *left = calloc(1, sizeof(*left));
    if (left == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to start device \"%s\" again",
                           r->gpu.info.name);
    log_message(LOG_WARNING, "%s; it is started again, to trace in the plain form",
                status_message());
    left->renderer = *r;
    pthread_mutex_lock(&lock);
    left->next = abandoned;
    abandoned = left;
    pthread_mutex_unlock(&lock);
    *r = (struct renderer){.chosen = r->chosen, .choice = r->choice, .camera = r->camera};
    choice_fall_back(&r->choice);
    return gpu_open(&r->gpu, &left->renderer.gpu.info, r->chosen.profile, 0);
}

enum status renderer_set_up(struct renderer *r, const struct lk_scene *scene)
{
    bool stuck;
    enum status status = set_up(r, scene, &stuck);
    if (!stuck)
        return status;
    status = start_again(r);
    return status == STATUS_OK ? set_up(r, scene, &stuck) : status;
}

// Sets the size of the next batch, and of the next run of them, by how long one of so many paths
// took.
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

    // Only full queues go by runs: smaller ones are on their way up, where each wait tells more.
    const double run = RUN_SECONDS / fmax(seconds * r->batch_paths / count, RUN_SECONDS / RUN_MAX);
    const bool full = paths >= r->wavefront.capacity;
    r->batch_run = full && run > 1.0 ? (uint32_t)run : 1;
}

// Adds what was counted since the counters were read before.
static void count_rays(struct renderer *r)
{
    for (uint32_t i = 0; i < r->wavefront.bounce_count; i++) {
        const struct counters *now = &r->counters[i];
        const struct counters *old = &r->before[i];
        const uint32_t directional = now->directional_rays - old->directional_rays;
        const uint32_t drawn = now->shadow_rays - old->shadow_rays;
        const uint32_t rays = now->rays + now->active - old->rays - old->active;
        r->rays.indirect += i > 0 ? rays : 0;
        r->rays.shadow += (uint64_t)drawn + directional;
        r->rays.directional += directional;
    }
    memcpy(r->before, r->counters, r->wavefront.bounce_count * sizeof(*r->counters));
}

// Enqueues the next batch of a sequence. Returns its paths through the first parameter.
static enum status enqueue_batch(uint32_t *count, struct renderer *r, struct sequence *sequence)
{
    const struct batch batch = sequence_batch(sequence, r->batch_paths);
    enum status status = pipeline_enqueue(&r->pipeline, &r->gpu, &r->scene, &r->wavefront, &batch,
                                          r->settings.depth);
    if (status == STATUS_OK)
        status = film_enqueue(&r->film, &r->gpu, &r->wavefront, &batch);
    if (status != STATUS_OK)
        return status;
    sequence_advance(sequence, &batch);
    r->rays.camera += batch.count;
    *count = batch.count;
    return STATUS_OK;
}

enum status renderer_batch(struct renderer *r, struct sequence *sequence, bool tells)
{
    const double begin = clock_seconds();
    uint32_t most = 0;  // paths of the largest batch
    uint64_t paths = 0; // of all
    enum status status = STATUS_OK;
    for (uint32_t i = 0; i < r->batch_run && status == STATUS_OK && !sequence_ended(sequence);
         i++) {
        uint32_t count = 0;
        status = enqueue_batch(&count, r, sequence);
        most = count > most ? count : most;
        paths += count;
    }
    if (status == STATUS_OK)
        status = buffer_read(&r->gpu, &r->wavefront.counters, r->counters,
                             r->wavefront.bounce_count * sizeof(*r->counters));
    if (status != STATUS_OK)
        return status;
    count_rays(r);
    if (tells && paths > 0)
        adapt(r, most, (clock_seconds() - begin) * most / (double)paths);
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
