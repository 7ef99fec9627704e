#include "pipeline/stages.h"

enum status scatter_build(struct scatter *out, const struct gpu *gpu,
                          const struct program_options *options, uint32_t *built)
{
    return kernel_build(&out->kernel, gpu, "scatter", options, built);
}

enum status scatter_enqueue(const struct scatter *scatter, const struct stage_context *context)
{
    const struct wavefront *w = context->wavefront;
    const struct kernel_arg args[] = {
        ARG_BUFFER(&w->settings),
        ARG_VALUE(context->batch),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->counters),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
        ARG_BUFFER(stage_next_queue(context)),
    };
    return kernel_enqueue(context->gpu, &scatter->kernel, args, sizeof(args) / sizeof(args[0]),
                          stage_shade_items(context));
}

void scatter_free(struct scatter *scatter)
{
    kernel_free(&scatter->kernel);
}
