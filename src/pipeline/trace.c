#include "pipeline/stages.h"

enum status trace_build(struct trace *out, const struct gpu *gpu,
                        const struct program_options *options, uint32_t *built)
{
    out->tints = options->alpha && options->layers;
    return kernel_build(&out->kernel, gpu, "trace", options, built);
}

enum status trace_enqueue(const struct trace *trace, const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const struct kernel_arg args[] = {
        ARGS_TRACED(scene),    ARG_BUFFER(&w->rays),     ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->hits),  ARG_BUFFER(&w->counters), ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->paths),
    };
    const size_t count = sizeof(args) / sizeof(args[0]) - (trace->tints ? 0 : 1);
    return kernel_enqueue(context->gpu, &trace->kernel, args, count,
                          stage_trace_items(context, &trace->kernel));
}

void trace_free(struct trace *trace)
{
    kernel_free(&trace->kernel);
}
