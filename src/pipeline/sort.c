#include "pipeline/stages.h"

#define SORT_BITS 4u // of a round, as in sort.cl

enum status sort_build(struct sort *out, const struct gpu *gpu,
                       const struct program_options *options, uint32_t *built)
{
    struct program program = {0};
    enum status status = program_build(&program, gpu, "sort", options);
    if (status != STATUS_OK)
        return status;
    *built += program.from_source;
    status = kernel_create(&out->keys, gpu, &program, "sort_keys");
    if (status == STATUS_OK)
        status = kernel_create(&out->count, gpu, &program, "sort_count");
    if (status == STATUS_OK)
        status = kernel_create(&out->scan, gpu, &program, "sort_scan");
    if (status == STATUS_OK)
        status = kernel_create(&out->scatter, gpu, &program, "sort_scatter");
    if (status == STATUS_OK)
        status = kernel_create(&out->ranges, gpu, &program, "sort_ranges");
    program_free(&program);
    return status;
}

// One round: elements move from side `from` of the keys and slots to the other.
static enum status enqueue_round(const struct sort *sort, const struct stage_context *context,
                                 uint32_t shift, int from)
{
    const struct wavefront *w = context->wavefront;
    const int to = 1 - from;
    const struct kernel_arg count[] = {
        ARG_BUFFER(&w->counters),   ARG_VALUE(context->bounce), ARG_VALUE(shift),
        ARG_BUFFER(&w->keys[from]), ARG_BUFFER(&w->totals),
    };
    const struct kernel_arg scan[] = {
        ARG_BUFFER(&w->counters),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->totals),
    };
    const struct kernel_arg scatter[] = {
        ARG_BUFFER(&w->counters),   ARG_VALUE(context->bounce),  ARG_VALUE(shift),
        ARG_BUFFER(&w->keys[from]), ARG_BUFFER(&w->slots[from]), ARG_BUFFER(&w->totals),
        ARG_BUFFER(&w->keys[to]),   ARG_BUFFER(&w->slots[to]),
    };
    enum status status = kernel_enqueue(context->gpu, &sort->count, count, 5,
                                        stage_loop_items(context, &sort->count));
    if (status == STATUS_OK)
        status = kernel_enqueue(context->gpu, &sort->scan, scan, 3, 1);
    if (status == STATUS_OK)
        status = kernel_enqueue(context->gpu, &sort->scatter, scatter, 8,
                                stage_loop_items(context, &sort->scatter));
    return status;
}

enum status sort_enqueue(const struct sort *sort, const struct stage_context *context)
{
    const struct wavefront *w = context->wavefront;
    const uint32_t material_count = context->scene->material_count;

    // Keys run to material_count, which marks a miss. Start on the side from which the last round
    // ends on 0.
    uint32_t rounds = 1;
    while (rounds * SORT_BITS < 32 && (material_count >> (rounds * SORT_BITS)) != 0)
        rounds++;
    int side = (int)(rounds & 1);

    const struct kernel_arg keys[] = {
        ARG_BUFFER(&w->counters),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(stage_queue(context)),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&context->scene->triangles),
        ARG_VALUE(material_count),
        ARG_BUFFER(&w->keys[side]),
        ARG_BUFFER(&w->slots[side]),
        ARG_BUFFER(&w->paths),
    };
    enum status status =
        kernel_enqueue(context->gpu, &sort->keys, keys, 9, stage_loop_items(context, &sort->keys));
    for (uint32_t round = 0; round < rounds && status == STATUS_OK; round++) {
        status = enqueue_round(sort, context, round * SORT_BITS, side);
        side = 1 - side;
    }

    const struct kernel_arg ranges[] = {
        ARG_BUFFER(&w->counters),  ARG_VALUE(context->bounce), ARG_BUFFER(&w->keys[0]),
        ARG_VALUE(material_count), ARG_BUFFER(&w->ranges),
    };
    if (status == STATUS_OK)
        status = kernel_enqueue(context->gpu, &sort->ranges, ranges, 5, material_count + 1);
    return status;
}

void sort_free(struct sort *sort)
{
    kernel_free(&sort->ranges);
    kernel_free(&sort->scatter);
    kernel_free(&sort->scan);
    kernel_free(&sort->count);
    kernel_free(&sort->keys);
}
