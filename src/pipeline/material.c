#include "pipeline/stages.h"

enum status material_build(struct material_stage *out, const struct gpu *gpu,
                           const struct program_options *options, uint32_t *built)
{
    out->textures_bound = options->textures_bound;
    out->normal_maps = options->normal_maps;
    out->layers = options->layers;
    out->sheen = options->sheen;
    return kernel_build(&out->kernel, gpu, "material", options, built);
}

// One launch for each material, its textures bound; its range is read on the device.
static enum status enqueue_bound(const struct material_stage *material,
                                 const struct stage_context *context, struct kernel_arg *args,
                                 size_t arg_count)
{
    const struct device_scene *scene = context->scene;
    const size_t loop_items = stage_loop_items(context, &material->kernel);
    const size_t items = context->batch.count < loop_items ? context->batch.count : loop_items;
    for (uint32_t m = 0; m < scene->material_count; m++) {
        size_t count = arg_count;
        args[count++] = (struct kernel_arg)ARG_VALUE(m);
        args[count++] = (struct kernel_arg)ARG_BUFFER(&context->wavefront->ranges);
        for (int use = 0; use < TEXTURE_USE_COUNT; use++) {
            const bool is_normal = use == TEXTURE_NORMAL || use == TEXTURE_COAT_NORMAL;
            const bool is_sheen = use >= TEXTURE_SHEEN_COLOR;
            if ((is_normal && !material->normal_maps) || (is_sheen && !material->sheen) ||
                (use > TEXTURE_NORMAL && !material->layers))
                continue;
            const uint32_t image = scene->material_images[m * TEXTURE_USE_COUNT + use];
            args[count++] = (struct kernel_arg)ARG_BUFFER(&scene->images[image]);
        }
        const enum status status =
            kernel_enqueue(context->gpu, &material->kernel, args, count, items);
        if (status != STATUS_OK)
            return status;
    }
    return STATUS_OK;
}

enum status material_enqueue(const struct material_stage *material,
                             const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const struct buffer *order = material->textures_bound ? &w->slots[0] : stage_queue(context);
    struct kernel_arg args[40] = {
        ARG_BUFFER(&w->settings),
        ARG_VALUE(context->batch),
        ARG_VALUE(context->bounce),
        ARG_BUFFER(&w->counters),
        ARG_BUFFER(order),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&scene->vertices),
        ARG_BUFFER(&scene->colors),
        ARG_BUFFER(&scene->triangles),
        ARG_BUFFER(&scene->materials),
        ARG_BUFFER(&scene->triangle_emitters),
        ARG_BUFFER(&scene->lights),
        ARG_BUFFER(&scene->shapes),
        ARG_BUFFER(&scene->light_nodes),
        ARG_BUFFER(&scene->light_parents),
        ARG_BUFFER(&scene->light_leaves),
        ARG_BUFFER(&w->rays),
        ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->hits),
        ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
    };
    size_t shared_count = 21; // arguments that every variant takes
    if (material->normal_maps)
        args[shared_count++] = (struct kernel_arg)ARG_BUFFER(&scene->tangents);
    if (material->textures_bound)
        return enqueue_bound(material, context, args, shared_count);
    args[shared_count] = (struct kernel_arg)ARG_BUFFER(&scene->texels);
    return kernel_enqueue(context->gpu, &material->kernel, args, shared_count + 1,
                          stage_shade_items(context));
}

void material_free(struct material_stage *material)
{
    kernel_free(&material->kernel);
}
