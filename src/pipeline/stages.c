#include "pipeline/stages.h"

// Groups of a looping kernel for each compute unit. Enough that the last ones to finish are short;
// on an NVIDIA unit, 8 groups of 256 are all the items it holds.
#define LOOP_GROUPS 8u

// Items of a persistent kernel for each compute unit: what a GPU keeps resident. On CPUs, a few, so
// that a thread that was held up does not hold up the rest.
#define PERSISTENT_ITEMS_GPU 2048u
#define PERSISTENT_ITEMS_CPU 4u

// Paths for each item of a kernel that first gathers all triangles: that takes as long as ten paths
// of five bounces. With 512 the Cornell box takes 1 to 5 % longer, with 2048 no less.
#define PATHS_OF_FEW 1024u

const struct buffer *stage_queue(const struct stage_context *context)
{
    return &context->wavefront->queue[context->bounce & 1];
}

const struct buffer *stage_next_queue(const struct stage_context *context)
{
    return &context->wavefront->queue[(context->bounce + 1) & 1];
}

size_t stage_loop_items(const struct stage_context *context, const struct kernel *kernel)
{
    return (size_t)context->gpu->info.compute_units * LOOP_GROUPS * kernel->group_size;
}

size_t stage_shade_items(const struct stage_context *context)
{
    const uint32_t count = context->batch.count;
    return context->gpu->info.is_cpu ? (count + PATH_RUN - 1) / PATH_RUN : count;
}

size_t stage_few_items(const struct stage_context *context)
{
    const uint32_t count = context->batch.count;
    const size_t by_paths = count / PATHS_OF_FEW + 1;
    const size_t by_cores = (size_t)context->gpu->info.compute_units * PERSISTENT_ITEMS_CPU;
    const size_t most = count / PATH_RUN + 1;
    const size_t items = by_paths > by_cores ? by_paths : by_cores;
    return items < most ? items : most;
}

size_t stage_light_items(const struct stage_context *context, const struct kernel *kernel)
{
    if (!kernel->persistent && context->gpu->info.is_cpu)
        return stage_shade_items(context);
    return stage_trace_items(context, kernel);
}

size_t stage_trace_items(const struct stage_context *context, const struct kernel *kernel)
{
    if (!kernel->persistent)
        return context->batch.count;
    const struct gpu_info *info = &context->gpu->info;
    const size_t per_unit =
        info->is_cpu ? PERSISTENT_ITEMS_CPU * kernel->group_size : PERSISTENT_ITEMS_GPU;
    return info->compute_units * per_unit;
}
