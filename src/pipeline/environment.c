#include "pipeline/stages.h"

enum status environment_stage_build(struct environment_stage *out, const struct gpu *gpu,
                                    const struct program_options *options, uint32_t *built)
{
    return kernel_build(&out->kernel, gpu, "environment", options, built);
}

enum status environment_stage_enqueue(const struct environment_stage *environment,
                                      const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const struct kernel_arg args[] = {
        ARG_BUFFER(&w->settings), ARG_VALUE(scene->map),          ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->counters), ARG_BUFFER(&scene->map_texels), ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->hits),     ARG_BUFFER(&w->rays),           ARG_BUFFER(&w->paths),
    };
    const size_t loop_items = stage_loop_items(context, &environment->kernel);
    const size_t items = context->batch.count < loop_items ? context->batch.count : loop_items;
    return kernel_enqueue(context->gpu, &environment->kernel, args, sizeof(args) / sizeof(args[0]),
                          items);
}

void environment_stage_free(struct environment_stage *environment)
{
    kernel_free(&environment->kernel);
}
