#include "pipeline/stages.h"

enum status compact_build(struct compact *out, const struct gpu *gpu,
                          const struct program_options *options, uint32_t *built)
{
    struct program program = {0};
    enum status status = program_build(&program, gpu, "compact", options);
    if (status != STATUS_OK)
        return status;
    *built += program.from_source;
    status = kernel_create(&out->count, gpu, &program, "compact_count");
    if (status == STATUS_OK)
        status = kernel_create(&out->scan, gpu, &program, "compact_scan");
    if (status == STATUS_OK)
        status = kernel_create(&out->scatter, gpu, &program, "compact_scatter");
    program_free(&program);
    return status;
}

enum status compact_enqueue(const struct compact *compact, const struct stage_context *context)
{
    const struct wavefront *w = context->wavefront;
    const struct buffer *queue = stage_queue(context);
    const struct buffer *next = stage_next_queue(context);
    const struct kernel_arg count[] = {
        ARG_BUFFER(&w->counters), ARG_VALUE(context->bounce), ARG_BUFFER(queue),
        ARG_BUFFER(&w->paths),    ARG_BUFFER(&w->totals),
    };
    const struct kernel_arg scan[] = {
        ARG_BUFFER(&w->counters),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->totals),
    };
    const struct kernel_arg scatter[] = {
        ARG_BUFFER(&w->counters), ARG_VALUE(context->bounce), ARG_BUFFER(queue),
        ARG_BUFFER(&w->paths),    ARG_BUFFER(&w->totals),     ARG_BUFFER(next),
    };
    enum status status = kernel_enqueue(context->gpu, &compact->count, count, 5,
                                        stage_loop_items(context, &compact->count));
    if (status == STATUS_OK)
        status = kernel_enqueue(context->gpu, &compact->scan, scan, 3, 1);
    if (status == STATUS_OK)
        status = kernel_enqueue(context->gpu, &compact->scatter, scatter, 6,
                                stage_loop_items(context, &compact->scatter));
    return status;
}

void compact_free(struct compact *compact)
{
    kernel_free(&compact->scatter);
    kernel_free(&compact->scan);
    kernel_free(&compact->count);
}
