#include "pipeline/pipeline.h"

#include "core/log.h"

static bool has_environment(const struct device_scene *scene)
{
    return scene->map.width > 0;
}

static bool has_far_lights(const struct device_scene *scene)
{
    return scene->directional_count > 0 || has_environment(scene);
}

// The stages that are built, those that trace for each form, and whether a scene needs them.
enum stage { RAYGEN, ENVIRONMENT, SORT, MATERIAL, SCATTER, STAGE_COUNT };
enum form_stage { TRACE, DIRECT, DIRECTIONAL, FORM_STAGE_COUNT };

static bool needs_stage(enum stage stage, const struct device_scene *scene,
                        const struct pipeline *p)
{
    switch (stage) {
    case ENVIRONMENT:
        return has_environment(scene);
    case SORT:
        return p->options.textures_bound;
    case SCATTER:
        return p->compares || !pipeline_has_shadows(scene);
    default:
        return true;
    }
}

static bool needs_form_stage(enum form_stage stage, const struct device_scene *scene,
                             const struct pipeline_form *form)
{
    switch (stage) {
    case TRACE:
        return form->traces;
    case DIRECT:
        return form->shadows && scene->light_count > 0;
    default:
        return form->shadows && has_far_lights(scene);
    }
}

static enum status build_stage(struct pipeline *p, enum stage stage, const struct gpu *gpu,
                               uint32_t *built)
{
    switch (stage) {
    case RAYGEN:
        return raygen_build(&p->raygen, gpu, &p->options, built);
    case ENVIRONMENT:
        return environment_stage_build(&p->environment, gpu, &p->options, built);
    case SORT:
        return sort_build(&p->sort, gpu, &p->options, built);
    case MATERIAL:
        return material_build(&p->material, gpu, &p->options, built);
    default:
        return scatter_build(&p->scatter, gpu, &p->options, built);
    }
}

static enum status build_form_stage(struct pipeline_form *form, enum form_stage stage,
                                    const struct gpu *gpu, uint32_t *built)
{
    switch (stage) {
    case TRACE:
        return trace_build(&form->trace, gpu, &form->options, built);
    case DIRECT:
        return direct_build(&form->direct, gpu, &form->options, built);
    default:
        return directional_build(&form->directional, gpu, &form->options, built);
    }
}

// Builds one thing, first all stages, then those of the forms, if it is needed.
static enum status build_job(struct pipeline *p, int job, const struct gpu *gpu,
                             const struct device_scene *scene, uint32_t *built)
{
    if (job < STAGE_COUNT)
        return needs_stage((enum stage)job, scene, p) ? build_stage(p, (enum stage)job, gpu, built)
                                                      : STATUS_OK;
    struct pipeline_form *form = &p->forms[(job - STAGE_COUNT) / FORM_STAGE_COUNT];
    const enum form_stage stage = (enum form_stage)((job - STAGE_COUNT) % FORM_STAGE_COUNT);
    return needs_form_stage(stage, scene, form) ? build_form_stage(form, stage, gpu, built)
                                                : STATUS_OK;
}

#define JOBS_MAX (STAGE_COUNT + FORM_STAGE_COUNT * (int)PIPELINE_FORMS_MAX)

enum status pipeline_build(struct pipeline *out, const struct gpu *gpu,
                           const struct device_scene *scene, const struct program_options *options,
                           const struct pipeline_form *forms, uint32_t form_count, bool compares)
{
    struct pipeline p = {.options = *options, .form_count = form_count, .compares = compares};
    enum status statuses[JOBS_MAX] = {STATUS_OK};
    uint32_t built[JOBS_MAX] = {0};
    const int job_count = STAGE_COUNT + FORM_STAGE_COUNT * (int)form_count;
    // A compiler of its own for each stage; PoCL has only one, and compiles at the first launch.
    const int threads = gpu->info.is_cpu ? 1 : job_count;
    for (uint32_t i = 0; i < form_count; i++)
        p.forms[i] = forms[i];

#pragma omp parallel for schedule(dynamic, 1) num_threads(threads)
    for (int i = 0; i < job_count; i++)
        statuses[i] = build_job(&p, i, gpu, scene, &built[i]);

    // Messages are a thread's own: what failed fails again for its message.
    enum status status = STATUS_OK;
    for (int i = 0; i < job_count && status == STATUS_OK; i++) {
        struct pipeline_form *form =
            i < STAGE_COUNT ? NULL : &p.forms[(i - STAGE_COUNT) / FORM_STAGE_COUNT];
        if (statuses[i] != STATUS_OK && (form == NULL || !form->failed))
            status = build_job(&p, i, gpu, scene, &built[i]);
        if (status != STATUS_OK && form != NULL && form->may_fail) {
            log_message(LOG_WARNING, "%s", status_message());
            form->failed = true;
            status = STATUS_OK;
        }
        p.built += built[i];
    }
    for (uint32_t i = 0; i < form_count; i++)
        if (p.forms[i].failed)
            pipeline_drop(&p, i);
    if (status != STATUS_OK) {
        pipeline_free(&p);
        return status;
    }
    *out = p;
    return STATUS_OK;
}

// Whether no stage is needed that is in neither of the kernels that take several.
static bool can_fuse(const struct device_scene *scene, const struct program_options *options)
{
    return !options->textures_bound && scene->light_count > 0 && !has_far_lights(scene);
}

bool pipeline_can_fuse(enum fusion fusion, const struct device_scene *scene,
                       const struct program_options *options)
{
    switch (fusion) {
    case FUSION_BOUNCES:
        return can_fuse(scene, options);
    case FUSION_PATHS:
        return can_fuse(scene, options) && paths_take(scene, options);
    default:
        return false;
    }
}

enum status pipeline_build_fused(struct pipeline *out, const struct gpu *gpu, enum fusion fusion,
                                 const struct program_options *options)
{
    struct pipeline p = {.options = *options, .fusion = fusion};
    enum status status = STATUS_OK;
    if (fusion == FUSION_PATHS) {
        status = paths_build(&p.paths, gpu, options, &p.built);
    } else {
        status = raygen_build(&p.raygen, gpu, options, &p.built); // it clears the counters
        if (status == STATUS_OK)
            status = bounce_build(&p.bounce, gpu, options, &p.built);
    }
    if (status == STATUS_OK)
        *out = p;
    else
        pipeline_free(&p);
    return status;
}

enum status pipeline_add_shadows(struct pipeline *pipeline, const struct gpu *gpu,
                                 const struct device_scene *scene, uint32_t form)
{
    struct pipeline_form *f = &pipeline->forms[form];
    if (f->shadows)
        return STATUS_OK;
    f->shadows = true;
    enum status status = STATUS_OK;
    for (int stage = DIRECT; stage < FORM_STAGE_COUNT && status == STATUS_OK; stage++)
        if (needs_form_stage((enum form_stage)stage, scene, f))
            status = build_form_stage(f, (enum form_stage)stage, gpu, &pipeline->built);
    if (status != STATUS_OK && f->may_fail) {
        log_message(LOG_WARNING, "%s", status_message());
        f->failed = true;
        pipeline_drop(pipeline, form);
        status = STATUS_OK;
    }
    return status;
}

void pipeline_drop(struct pipeline *pipeline, uint32_t form)
{
    struct pipeline_form *f = &pipeline->forms[form];
    directional_free(&f->directional);
    direct_free(&f->direct);
    trace_free(&f->trace);
}

uint32_t pipeline_bounces(const struct device_scene *scene, uint32_t depth)
{
    return scene->emitter_count > 0 && scene->glossy ? depth + 1 : depth;
}

bool pipeline_has_shadows(const struct device_scene *scene)
{
    return scene->light_count > 0 || has_far_lights(scene);
}

enum status pipeline_trace(const struct pipeline *p, uint32_t form,
                           const struct stage_context *context)
{
    return trace_enqueue(&p->forms[form].trace, context);
}

enum status pipeline_shade(const struct pipeline *p, const struct stage_context *context)
{
    enum status status = STATUS_OK;
    if (has_environment(context->scene))
        status = environment_stage_enqueue(&p->environment, context);
    if (status == STATUS_OK && p->options.textures_bound)
        status = sort_enqueue(&p->sort, context);
    if (status == STATUS_OK)
        status = material_enqueue(&p->material, context);
    return status;
}

enum status pipeline_light(const struct pipeline *p, uint32_t form,
                           const struct stage_context *context)
{
    const bool has_far = has_far_lights(context->scene);
    struct stage_context near = *context;
    near.scatters = context->scatters && !has_far;
    enum status status = STATUS_OK;
    if (context->scene->light_count > 0)
        status = direct_enqueue(&p->forms[form].direct, &near);
    if (status == STATUS_OK && has_far)
        status = directional_enqueue(&p->forms[form].directional, context);
    return status;
}

enum status pipeline_go_on(const struct pipeline *p, const struct stage_context *context)
{
    return scatter_enqueue(&p->scatter, context);
}

enum ray_class pipeline_class(uint32_t bounce)
{
    return bounce == 0 ? RAYS_CAMERA : bounce == 1 ? RAYS_FIRST_BOUNCE : RAYS_LATER_BOUNCES;
}

static enum status enqueue_bounces(const struct pipeline *pipeline, struct stage_context *context,
                                   uint32_t bounces)
{
    struct stage_context none = *context;
    none.batch.count = 0; // paths: bounce starts them
    enum status status = raygen_enqueue(&pipeline->raygen, &none);
    for (; context->bounce < bounces && status == STATUS_OK; context->bounce++) {
        context->scatters = context->bounce + 1 < bounces;
        status = bounce_enqueue(&pipeline->bounce, context);
    }
    return status;
}

enum status pipeline_enqueue(const struct pipeline *pipeline, struct gpu *gpu,
                             const struct device_scene *scene, const struct wavefront *wavefront,
                             const struct batch *batch, uint32_t depth)
{
    struct stage_context context = {
        .gpu = gpu,
        .scene = scene,
        .wavefront = wavefront,
        .batch = *batch,
        .coherent = true, // camera rays
    };

    const uint32_t bounces = pipeline_bounces(scene, depth);
    const uint32_t *form_of = pipeline->form_of;
    if (pipeline->fusion == FUSION_BOUNCES)
        return enqueue_bounces(pipeline, &context, bounces);
    if (pipeline->fusion == FUSION_PATHS)
        return paths_enqueue(&pipeline->paths, &context);
    enum status status = raygen_enqueue(&pipeline->raygen, &context);
    for (; context.bounce < bounces && status == STATUS_OK; context.bounce++) {
        const bool goes_on = context.bounce + 1 < bounces;
        context.scatters = goes_on && pipeline_has_shadows(scene);
        status = pipeline_trace(pipeline, form_of[pipeline_class(context.bounce)], &context);
        if (status == STATUS_OK)
            status = pipeline_shade(pipeline, &context);
        if (status == STATUS_OK && context.bounce < depth) // else emission is collected only
            status = pipeline_light(pipeline, form_of[RAYS_SHADOW], &context);
        if (status == STATUS_OK && goes_on && !context.scatters)
            status = pipeline_go_on(pipeline, &context);
        context.coherent = false;
    }
    return status;
}

void pipeline_free(struct pipeline *pipeline)
{
    bounce_free(&pipeline->bounce);
    paths_free(&pipeline->paths);
    scatter_free(&pipeline->scatter);
    for (uint32_t i = 0; i < pipeline->form_count; i++)
        pipeline_drop(pipeline, i);
    material_free(&pipeline->material);
    sort_free(&pipeline->sort);
    environment_stage_free(&pipeline->environment);
    raygen_free(&pipeline->raygen);
    *pipeline = (struct pipeline){0};
}
