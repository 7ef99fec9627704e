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
    const struct kernel_arg args[] = {
        ARGS_TRACED(scene, directional->layout),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->counters),
        ARG_BUFFER(&w->settings),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&scene->directional),
        // From here on only where there is an environment.
        ARG_VALUE(context->batch),
        ARG_VALUE(scene->map),
        ARG_BUFFER(&scene->map_texels),
        ARG_BUFFER(&scene->map_alias),
        ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
    };
    const size_t count = sizeof(args) / sizeof(args[0]) - (scene->map.width > 0 ? 0 : 6);
    return kernel_enqueue(context->gpu, &directional->kernel, args, count,
                          stage_light_items(context, &directional->kernel));
}

void directional_free(struct directional *directional)
{
    kernel_free(&directional->kernel);
}
