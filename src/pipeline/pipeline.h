/**
 * @file
 * The pipeline of thesis section 3.5 (Figure 5): the stages in order, for one batch of paths.
 */
#ifndef PIPELINE_PIPELINE_H
#define PIPELINE_PIPELINE_H

#include <stdint.h>

#include "core/status.h"
#include "pipeline/stages.h"

/** Kinds of rays, each of which may be traced in a way of its own. */
enum ray_class { RAYS_CAMERA, RAYS_FIRST_BOUNCE, RAYS_LATER_BOUNCES, RAYS_SHADOW, RAY_CLASSES };

/** The kind of the rays that a bounce traces. */
enum ray_class pipeline_class(uint32_t bounce);

#define PIPELINE_FORMS_MAX 12u

/** What one kernel does of what stages do. */
enum fusion {
    FUSION_NONE,    // its own stage
    FUSION_BOUNCES, // all of a bounce: bounce
    FUSION_PATHS    // all from raygen to the path's end, on CPUs: paths
};

/** A way to trace: the stages that do, built alike. All zero is a valid empty one. */
struct pipeline_form {
    struct program_options options;
    bool traces, shadows; // what it is for: trace; direct and directional
    bool may_fail;        // and if it does not compile, that is no more than a warning
    bool failed;          // it did not: nothing of it is built
    struct trace trace;
    struct direct direct;           // unused without lights in the tree
    struct directional directional; // unused without directional lights or an environment
};

/** The built stages. All zero is a valid empty one. */
struct pipeline {
    struct raygen raygen;
    struct environment_stage environment; // unused without an environment
    struct sort sort;                     // unused unless textures are bound
    struct material_stage material;
    struct scatter scatter;   // unused unless no stage traces shadow rays, or forms are compared
    struct bounce bounce;     // in place of all but raygen; unused unless bounces are fused
    struct paths_stage paths; // in place of all; unused unless paths are fused
    enum fusion fusion;
    struct pipeline_form forms[PIPELINE_FORMS_MAX];
    uint32_t form_count;
    uint32_t form_of[RAY_CLASSES]; // how rays are traced
    bool compares;                 // forms are to be compared
    struct program_options options;
    uint32_t built; // programs compiled from source
};

/**
 * Builds the stages that this scene needs. Fails as kernel_build().
 *
 * @param options     Of stages that do not trace.
 * @param forms       [form_count] of the others; options, traces, shadows and may_fail are read.
 * @param compares    Several may light the same hits before the stage scatter sends them on.
 */
enum status pipeline_build(struct pipeline *out, const struct gpu *gpu,
                           const struct device_scene *scene, const struct program_options *options,
                           const struct pipeline_form *forms, uint32_t form_count, bool compares);

/**
 * Builds the pipeline of one kernel: that of paths, or that of bounces and raygen, which is left
 * with clearing counters. For scenes that pipeline_can_fuse(). Fails as kernel_build().
 */
enum status pipeline_build_fused(struct pipeline *out, const struct gpu *gpu, enum fusion fusion,
                                 const struct program_options *options);

/**
 * Whether its kernel does all that this scene needs: textures from the pool, and light from the
 * tree's lights alone; that of paths takes few triangles that are all Lambert, in the 8-wide BVH.
 * Not for FUSION_NONE.
 */
bool pipeline_can_fuse(enum fusion fusion, const struct device_scene *scene,
                       const struct program_options *options);

/** Builds a form's stages for shadow rays if they are not. Fails, or marks it as failed, as above.
 */
enum status pipeline_add_shadows(struct pipeline *pipeline, const struct gpu *gpu,
                                 const struct device_scene *scene, uint32_t form);

/** Releases a form that is not needed any more. */
void pipeline_drop(struct pipeline *pipeline, uint32_t form);

/**
 * Enqueues all stages of one batch but the film, and returns; nothing is waited for.
 *
 * @param depth  Shaded hits of a path.
 */
enum status pipeline_enqueue(const struct pipeline *pipeline, struct gpu *gpu,
                             const struct device_scene *scene, const struct wavefront *wavefront,
                             const struct batch *batch, uint32_t depth);

/** Bounces that are enqueued: after the last shaded hit a path may go on once more, to collect what
 * a glossy surface mirrors. */
uint32_t pipeline_bounces(const struct device_scene *scene, uint32_t depth);

/** Whether shadow rays are traced in this scene. */
bool pipeline_has_shadows(const struct device_scene *scene);

/** The parts of a bounce, in order: its rays, in one of the forms; its hits; its shadow rays, in
 * one of the forms; the rays of the next. */
enum status pipeline_trace(const struct pipeline *pipeline, uint32_t form,
                           const struct stage_context *context);
enum status pipeline_shade(const struct pipeline *pipeline, const struct stage_context *context);
enum status pipeline_light(const struct pipeline *pipeline, uint32_t form,
                           const struct stage_context *context);
enum status pipeline_go_on(const struct pipeline *pipeline, const struct stage_context *context);

void pipeline_free(struct pipeline *pipeline);

#endif
