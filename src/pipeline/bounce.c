#include "pipeline/stages.h"

enum status bounce_build(struct bounce *out, const struct gpu *gpu,
                         const struct program_options *options, uint32_t *built)
{
    out->layout = program_layout(options);
    out->normal_maps = options->normal_maps;
    return kernel_build(&out->kernel, gpu, "bounce", options, built);
}

enum status bounce_enqueue(const struct bounce *bounce, const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const struct kernel_arg args[] = {
        ARGS_TRACED(scene, bounce->layout),
        ARG_BUFFER(&w->settings),
        ARG_BUFFER(&w->camera),
        ARG_VALUE(context->batch),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&scene->triangle_emitters),
        ARG_BUFFER(&scene->lights),
        ARG_BUFFER(&scene->shapes),
        ARG_BUFFER(&scene->light_nodes),
        ARG_BUFFER(&scene->light_parents),
        ARG_BUFFER(&scene->light_leaves),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->counters),
        ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
        ARG_VALUE(context->scatters),
        ARG_BUFFER(stage_next_queue(context)),
        ARG_BUFFER(&scene->tangents),
    };
    const size_t count = sizeof(args) / sizeof(args[0]) - (bounce->normal_maps ? 0 : 1);
    return kernel_enqueue(context->gpu, &bounce->kernel, args, count, context->batch.count);
}

void bounce_free(struct bounce *bounce)
{
    kernel_free(&bounce->kernel);
}
