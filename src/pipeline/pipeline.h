/**
 * @file
 * The pipeline of thesis section 3.5 (Figure 5): the stages in order, for one batch of paths.
 */
#ifndef PIPELINE_PIPELINE_H
#define PIPELINE_PIPELINE_H

#include <stdint.h>

#include "core/status.h"
#include "pipeline/stages.h"

/** The built stages. All zero is a valid empty one. */
struct pipeline {
    struct raygen raygen;
    struct trace trace;
    struct environment_stage environment; // unused without an environment
    struct sort sort;                     // unused unless textures are bound
    struct material_stage material;
    struct direct direct;           // unused without lights in the tree
    struct directional directional; // unused without directional lights or an environment
    struct scatter scatter;
    struct compact compact;
    struct program_options options;
    uint32_t built; // programs compiled from source
};

/** Builds the stages that this scene needs. Fails as kernel_build(). */
enum status pipeline_build(struct pipeline *out, const struct gpu *gpu,
                           const struct device_scene *scene, const struct program_options *options);

/**
 * Enqueues all stages of one batch but the film, and returns; nothing is waited for.
 *
 * @param depth  Shaded hits of a path.
 */
enum status pipeline_enqueue(const struct pipeline *pipeline, struct gpu *gpu,
                             const struct device_scene *scene, const struct wavefront *wavefront,
                             const struct batch *batch, uint32_t depth);

void pipeline_free(struct pipeline *pipeline);

#endif
