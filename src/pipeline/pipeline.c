#include "pipeline/pipeline.h"

static bool has_environment(const struct device_scene *scene)
{
    return scene->map.width > 0;
}

static bool has_far_lights(const struct device_scene *scene)
{
    return scene->directional_count > 0 || has_environment(scene);
}

// The stages that are built, and whether a scene needs them.
enum stage {
    RAYGEN,
    TRACE,
    ENVIRONMENT,
    SORT,
    MATERIAL,
    DIRECT,
    DIRECTIONAL,
    SCATTER,
    COMPACT,
    STAGE_COUNT
};

static bool needs_stage(enum stage stage, const struct device_scene *scene,
                        const struct program_options *options)
{
    switch (stage) {
    case ENVIRONMENT:
        return has_environment(scene);
    case SORT:
        return options->textures_bound;
    case DIRECT:
        return scene->light_count > 0;
    case DIRECTIONAL:
        return has_far_lights(scene);
    default:
        return true;
    }
}

static enum status build_stage(struct pipeline *p, enum stage stage, const struct gpu *gpu,
                               uint32_t *built)
{
    switch (stage) {
    case RAYGEN:
        return raygen_build(&p->raygen, gpu, &p->options, built);
    case TRACE:
        return trace_build(&p->trace, gpu, &p->options, built);
    case ENVIRONMENT:
        return environment_stage_build(&p->environment, gpu, &p->options, built);
    case SORT:
        return sort_build(&p->sort, gpu, &p->options, built);
    case MATERIAL:
        return material_build(&p->material, gpu, &p->options, built);
    case DIRECT:
        return direct_build(&p->direct, gpu, &p->options, built);
    case DIRECTIONAL:
        return directional_build(&p->directional, gpu, &p->options, built);
    case SCATTER:
        return scatter_build(&p->scatter, gpu, &p->options, built);
    default:
        return compact_build(&p->compact, gpu, &p->options, built);
    }
}

enum status pipeline_build(struct pipeline *out, const struct gpu *gpu,
                           const struct device_scene *scene, const struct program_options *options)
{
    struct pipeline p = {.options = *options};
    enum status statuses[STAGE_COUNT] = {STATUS_OK};
    uint32_t built[STAGE_COUNT] = {0};

    // A compiler of its own for each stage; PoCL has only one, and compiles at the first launch.
#pragma omp parallel for schedule(dynamic, 1) num_threads(gpu->info.is_cpu ? 1 : STAGE_COUNT)
    for (int i = 0; i < STAGE_COUNT; i++)
        if (needs_stage((enum stage)i, scene, options))
            statuses[i] = build_stage(&p, (enum stage)i, gpu, &built[i]);

    // Messages are a thread's own: what failed fails again for its message.
    enum status status = STATUS_OK;
    for (int i = 0; i < STAGE_COUNT && status == STATUS_OK; i++) {
        if (statuses[i] != STATUS_OK)
            status = build_stage(&p, (enum stage)i, gpu, &built[i]);
        p.built += built[i];
    }
    if (status != STATUS_OK) {
        pipeline_free(&p);
        return status;
    }
    *out = p;
    return STATUS_OK;
}

// One bounce: what the rays of the queue hit, light on it, and the rays that go on.
static enum status enqueue_bounce(const struct pipeline *p, const struct stage_context *context,
                                  uint32_t depth, uint32_t bounces)
{
    const bool shades = context->bounce < depth; // else emission is collected only
    enum status status = trace_enqueue(&p->trace, context);
    if (status == STATUS_OK && has_environment(context->scene))
        status = environment_stage_enqueue(&p->environment, context);
    if (status == STATUS_OK && p->options.textures_bound)
        status = sort_enqueue(&p->sort, context);
    if (status == STATUS_OK)
        status = material_enqueue(&p->material, context);
    if (status == STATUS_OK && shades && context->scene->light_count > 0)
        status = direct_enqueue(&p->direct, context);
    if (status == STATUS_OK && shades && has_far_lights(context->scene))
        status = directional_enqueue(&p->directional, context);
    if (context->bounce + 1 == bounces)
        return status;
    if (status == STATUS_OK)
        status = scatter_enqueue(&p->scatter, context);
    if (status == STATUS_OK)
        status = compact_enqueue(&p->compact, context);
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

    // After the last shaded hit a path may go on once more, to collect what a glossy surface
    // mirrors.
    const uint32_t bounces = scene->emitter_count > 0 && scene->glossy ? depth + 1 : depth;
    enum status status = raygen_enqueue(&pipeline->raygen, &context);
    for (; context.bounce < bounces && status == STATUS_OK; context.bounce++) {
        status = enqueue_bounce(pipeline, &context, depth, bounces);
        context.coherent = false;
    }
    return status;
}

void pipeline_free(struct pipeline *pipeline)
{
    compact_free(&pipeline->compact);
    scatter_free(&pipeline->scatter);
    directional_free(&pipeline->directional);
    direct_free(&pipeline->direct);
    material_free(&pipeline->material);
    sort_free(&pipeline->sort);
    environment_stage_free(&pipeline->environment);
    trace_free(&pipeline->trace);
    raygen_free(&pipeline->raygen);
    *pipeline = (struct pipeline){0};
}
