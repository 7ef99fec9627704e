#include "pipeline/stages.h"

enum status raygen_build(struct raygen *out, const struct gpu *gpu,
                         const struct program_options *options, uint32_t *built)
{
    return kernel_build(&out->kernel, gpu, "raygen", options, built);
}

enum status raygen_enqueue(const struct raygen *raygen, const struct stage_context *context)
{
    const struct wavefront *w = context->wavefront;
    const size_t shade_items = stage_shade_items(context);
    const size_t items =
        shade_items > w->bounce_count ? shade_items : w->bounce_count; // it clears counters, too
    const struct kernel_arg args[] = {
        ARG_BUFFER(&w->settings),   ARG_BUFFER(&w->camera),   ARG_VALUE(context->batch),
        ARG_VALUE(w->bounce_count), ARG_BUFFER(&w->rays),     ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->queue[0]),   ARG_BUFFER(&w->counters), ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
    };
    return kernel_enqueue(context->gpu, &raygen->kernel, args, sizeof(args) / sizeof(args[0]),
                          items);
}

void raygen_free(struct raygen *raygen)
{
    kernel_free(&raygen->kernel);
}
