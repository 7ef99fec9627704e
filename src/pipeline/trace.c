#include <string.h>

#include "pipeline/stages.h"
#include "shared/bvh_wide.h"
#include "shared/ray.h"

enum status trace_build(struct trace *out, const struct gpu *gpu,
                        const struct program_options *options, uint32_t *built)
{
    struct program program = {0};
    out->tints = options->alpha && options->layers;
    out->layout = program_layout(options);
    enum status status = program_build(&program, gpu, "trace", options);
    if (status != STATUS_OK)
        return status;
    *built += program.from_source;
    status = kernel_create(&out->kernel, gpu, &program, "trace");
    if (status == STATUS_OK && gpu->info.is_cpu && options->bvh_wide && !options->any_hit)
        status = kernel_create(&out->packets, gpu, &program, "trace_packets");
    if (status == STATUS_OK && gpu->info.is_cpu && options->bvh_wide && !options->any_hit &&
        !options->alpha)
        status = kernel_create(&out->few, gpu, &program, "trace_few");
    out->kernel.persistent = options->persistent;
    memcpy(out->packets.name, out->kernel.name, sizeof(out->packets.name)); // one row of a profile
    memcpy(out->few.name, out->kernel.name, sizeof(out->few.name));
    program_free(&program);
    return status;
}

enum status trace_enqueue(const struct trace *trace, const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    struct kernel_arg args[] = {
        ARGS_TRACED(scene, trace->layout),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->counters),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->paths),
    };
    const size_t count = sizeof(args) / sizeof(args[0]) - (trace->tints ? 0 : 1);
    if (context->coherent && trace->packets.handle != NULL)
        return kernel_enqueue(context->gpu, &trace->packets, args, count,
                              (context->batch.count + RAY_PACKET - 1) / RAY_PACKET);
    const uint32_t block_count =
        (uint32_t)(scene->bvhs[LAYOUT_WIDE].woop.size / sizeof(struct woop_block));
    if (trace->few.handle != NULL && block_count <= WIDE_FEW_BLOCKS) {
        args[count] = (struct kernel_arg)ARG_VALUE(block_count); // in place of the paths
        return kernel_enqueue(context->gpu, &trace->few, args, count + 1, stage_few_items(context));
    }
    return kernel_enqueue(context->gpu, &trace->kernel, args, count,
                          stage_trace_items(context, &trace->kernel));
}

void trace_free(struct trace *trace)
{
    kernel_free(&trace->few);
    kernel_free(&trace->packets);
    kernel_free(&trace->kernel);
}
