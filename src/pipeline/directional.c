#include "pipeline/stages.h"

enum status directional_build(struct directional *out, const struct gpu *gpu,
                              const struct program_options *options, uint32_t *built)
{
    out->layout = program_layout(options);
    return kernel_build(&out->kernel, gpu, "directional", options, built);
}

enum status directional_enqueue(const struct directional *directional,
                                const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const bool has_map = scene->map.width > 0;
    struct kernel_arg args[32] = {
        ARGS_TRACED(scene, directional->layout),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->counters),
        ARG_BUFFER(&w->settings),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&scene->directional),
        ARG_VALUE(context->batch),
        ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
    };
    size_t count = 19; // arguments so far
    if (has_map) {
        args[count++] = (struct kernel_arg)ARG_VALUE(scene->map);
        args[count++] = (struct kernel_arg)ARG_BUFFER(&scene->map_texels);
        args[count++] = (struct kernel_arg)ARG_BUFFER(&scene->map_alias);
    }
    args[count++] = (struct kernel_arg)ARG_VALUE(context->scatters);
    args[count++] = (struct kernel_arg)ARG_BUFFER(stage_next_queue(context));
    return kernel_enqueue(context->gpu, &directional->kernel, args, count,
                          stage_light_items(context, &directional->kernel));
}

void directional_free(struct directional *directional)
{
    kernel_free(&directional->kernel);
}
