/**
 * @file
 * The stages: each sets the arguments of its kernels and enqueues them, no more. What a stage reads
 * and writes stands at the head of the .cl of the same name.
 *
 * Every *_build() can fail as kernel_build() does and adds to *built the programs it compiled;
 * every
 * *_enqueue() as kernel_enqueue(). Every *_free() is safe on an all-zero stage.
 */
#ifndef PIPELINE_STAGES_H
#define PIPELINE_STAGES_H

#include <stdint.h>

#include "device/program.h"
#include "device/upload.h"
#include "pipeline/wavefront.h"

/** What every stage is given. */
struct stage_context {
    struct gpu *gpu;
    const struct device_scene *scene;
    const struct wavefront *wavefront;
    struct batch batch;
    uint32_t bounce;
    bool coherent;     // neighbours in the queue have rays that run alike
    uint32_t scatters; // 1: the stage that adds the last light sends paths on, too
};

/** The arguments that every kernel that traces takes first: TRACED_PARAMETERS of cl/lib/traverse.h.
 */
#define ARGS_TRACED(scene, layout)                                                                 \
    ARG_BUFFER(&(scene)->bvhs[layout].nodes),                                                      \
        ARG_BUFFER(&(scene)->bvhs[(scene)->bvhs[layout].leaves].woop),                             \
        ARG_BUFFER(&(scene)->bvhs[(scene)->bvhs[layout].leaves].refs),                             \
        ARG_BUFFER(&(scene)->vertices), ARG_BUFFER(&(scene)->colors),                              \
        ARG_BUFFER(&(scene)->triangles), ARG_BUFFER(&(scene)->materials),                          \
        ARG_BUFFER(&(scene)->texels)

/** This bounce's queue, and the next one's. */
const struct buffer *stage_queue(const struct stage_context *context);
const struct buffer *stage_next_queue(const struct stage_context *context);

/** Work items of a kernel that loops until the work is done: enough to fill the device. */
size_t stage_loop_items(const struct stage_context *context, const struct kernel *kernel);

/** Work items of a kernel that shades: on CPUs one for each run of paths (cl/lib/shade_lanes.h). */
size_t stage_shade_items(const struct stage_context *context);

/** Work items of a kernel that gathers all triangles to begin with (cl/lib/traverse_few.h). */
size_t stage_few_items(const struct stage_context *context);

/** Work items of a kernel that traces. */
size_t stage_trace_items(const struct stage_context *context, const struct kernel *kernel);

/** Work items of a kernel that draws shadow rays and traces them: on CPUs as one that shades. */
size_t stage_light_items(const struct stage_context *context, const struct kernel *kernel);

struct raygen {
    struct kernel kernel;
};

enum status raygen_build(struct raygen *out, const struct gpu *gpu,
                         const struct program_options *options, uint32_t *built);
enum status raygen_enqueue(const struct raygen *raygen, const struct stage_context *context);
void raygen_free(struct raygen *raygen);

struct trace {
    struct kernel kernel;
    struct kernel packets;  // for rays that run alike; empty where there is none
    struct kernel few;      // for other rays among few triangles; empty where there is none
    bool tints;             // the variant that writes paths
    enum bvh_layout layout; // that it reads
};

enum status trace_build(struct trace *out, const struct gpu *gpu,
                        const struct program_options *options, uint32_t *built);
enum status trace_enqueue(const struct trace *trace, const struct stage_context *context);
void trace_free(struct trace *trace);

struct environment_stage {
    struct kernel kernel;
};

enum status environment_stage_build(struct environment_stage *out, const struct gpu *gpu,
                                    const struct program_options *options, uint32_t *built);
enum status environment_stage_enqueue(const struct environment_stage *environment,
                                      const struct stage_context *context);
void environment_stage_free(struct environment_stage *environment);

struct sort {
    struct kernel keys, count, scan, scatter, ranges;
};

enum status sort_build(struct sort *out, const struct gpu *gpu,
                       const struct program_options *options, uint32_t *built);

/** Sorts this bounce's queue by material into wavefront.slots[0] and wavefront.ranges. */
enum status sort_enqueue(const struct sort *sort, const struct stage_context *context);
void sort_free(struct sort *sort);

struct material_stage {
    struct kernel kernel;
    bool textures_bound, normal_maps, layers, sheen; // the variant
};

enum status material_build(struct material_stage *out, const struct gpu *gpu,
                           const struct program_options *options, uint32_t *built);
enum status material_enqueue(const struct material_stage *material,
                             const struct stage_context *context);
void material_free(struct material_stage *material);

struct direct {
    struct kernel kernel;
    enum bvh_layout layout;
};

enum status direct_build(struct direct *out, const struct gpu *gpu,
                         const struct program_options *options, uint32_t *built);
enum status direct_enqueue(const struct direct *direct, const struct stage_context *context);
void direct_free(struct direct *direct);

struct directional {
    struct kernel kernel;
    enum bvh_layout layout;
};

enum status directional_build(struct directional *out, const struct gpu *gpu,
                              const struct program_options *options, uint32_t *built);
enum status directional_enqueue(const struct directional *directional,
                                const struct stage_context *context);
void directional_free(struct directional *directional);

/** All from raygen to scatter in one. */
struct bounce {
    struct kernel kernel;
    enum bvh_layout layout;
    bool normal_maps; // the variant
};

enum status bounce_build(struct bounce *out, const struct gpu *gpu,
                         const struct program_options *options, uint32_t *built);
enum status bounce_enqueue(const struct bounce *bounce, const struct stage_context *context);
void bounce_free(struct bounce *bounce);

struct scatter {
    struct kernel kernel;
};

enum status scatter_build(struct scatter *out, const struct gpu *gpu,
                          const struct program_options *options, uint32_t *built);
enum status scatter_enqueue(const struct scatter *scatter, const struct stage_context *context);
void scatter_free(struct scatter *scatter);

/** In place of all stages from raygen to scatter, on CPUs. */
struct paths_stage {
    struct kernel kernel;
};

/** Whether it can do what the stages of a form do with this scene's triangles: few, all Lambert. */
bool paths_take(const struct device_scene *scene, const struct program_options *form);
enum status paths_build(struct paths_stage *out, const struct gpu *gpu,
                        const struct program_options *options, uint32_t *built);
enum status paths_enqueue(const struct paths_stage *paths, const struct stage_context *context);
void paths_free(struct paths_stage *paths);

#endif
