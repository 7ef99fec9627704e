#include "pipeline/stages.h"

enum status direct_build(struct direct *out, const struct gpu *gpu,
                         const struct program_options *options, uint32_t *built)
{
    out->layout = program_layout(options);
    return kernel_build(&out->kernel, gpu, "direct", options, built);
}

enum status direct_enqueue(const struct direct *direct, const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const struct kernel_arg args[] = {
        ARGS_TRACED(scene, direct->layout),
        ARG_BUFFER(&w->settings),
        ARG_VALUE(context->batch),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&scene->lights),
        ARG_BUFFER(&scene->shapes),
        ARG_BUFFER(&scene->light_nodes),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->counters),
        ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
        ARG_VALUE(context->scatters),
        ARG_BUFFER(stage_next_queue(context)),
    };
    return kernel_enqueue(context->gpu, &direct->kernel, args, sizeof(args) / sizeof(args[0]),
                          stage_light_items(context, &direct->kernel));
}

void direct_free(struct direct *direct)
{
    kernel_free(&direct->kernel);
}
