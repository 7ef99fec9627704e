#include "pipeline/stages.h"
#include "shared/bvh_wide.h"

static uint32_t block_count(const struct device_scene *scene)
{
    return (uint32_t)(scene->bvhs[LAYOUT_WIDE].woop.size / sizeof(struct woop_block));
}

bool paths_take(const struct device_scene *scene, const struct program_options *form)
{
    const uint32_t blocks = block_count(scene);
    return form->bvh_wide && blocks > 0 && blocks <= WIDE_FEW_BLOCKS && scene->lambert &&
           !scene->alpha;
}

enum status paths_build(struct paths_stage *out, const struct gpu *gpu,
                        const struct program_options *options, uint32_t *built)
{
    struct program_options wide = *options;
    wide.bvh_wide = true;
    wide.persistent = false;
    return kernel_build(&out->kernel, gpu, "paths", &wide, built);
}

enum status paths_enqueue(const struct paths_stage *paths, const struct stage_context *context)
{
    const struct device_scene *scene = context->scene;
    const struct wavefront *w = context->wavefront;
    const struct device_bvh *wide = &scene->bvhs[LAYOUT_WIDE];
    const uint32_t blocks = block_count(scene);
    const struct kernel_arg args[] = {
        ARG_BUFFER(&wide->woop),          ARG_BUFFER(&wide->refs),
        ARG_BUFFER(&scene->vertices),     ARG_BUFFER(&scene->colors),
        ARG_BUFFER(&scene->triangles),    ARG_BUFFER(&scene->materials),
        ARG_BUFFER(&scene->texels),       ARG_VALUE(blocks),
        ARG_BUFFER(&w->settings),         ARG_BUFFER(&w->camera),
        ARG_VALUE(context->batch),        ARG_BUFFER(&scene->triangle_emitters),
        ARG_BUFFER(&scene->lights),       ARG_BUFFER(&scene->shapes),
        ARG_BUFFER(&scene->light_nodes),  ARG_BUFFER(&scene->light_parents),
        ARG_BUFFER(&scene->light_leaves), ARG_BUFFER(&w->paths),
        ARG_BUFFER(&w->counters),         ARG_BUFFER(&w->points),
        ARG_BUFFER(&w->places),
    };
    return kernel_enqueue(context->gpu, &paths->kernel, args, sizeof(args) / sizeof(args[0]),
                          stage_few_items(context));
}

void paths_free(struct paths_stage *paths)
{
    kernel_free(&paths->kernel);
}
