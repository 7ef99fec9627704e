/**
 * @file
 * The host's half of the work: from a scene to what kernels need.
 */
#ifndef PREPARE_H
#define PREPARE_H

#include "core/status.h"
#include "device/upload.h"
#include "engine.h"

/**
 * Prepares a scene and its surroundings for these settings: what has not been done for them yet.
 * Fails as the modules of prep/ do.
 *
 * @param settings  split_threshold, leaf_size, bvh_build, light_sampler (not auto) and what makes
 *                  the environment are looked at.
 * @param layouts   Of the BVH, those asked for: the sum of 1 << LK_BVH_..., auto not among them.
 */
enum status prepare_scene(struct lk_scene *scene, const struct lk_settings *settings,
                          unsigned layouts);

/** Prepares only what depends on no setting: triangles, lights, materials. */
enum status prepare_geometry(struct lk_scene *scene);

/** Release what was prepared. Safe on unprepared ones. */
void prepared_free(struct prepared *prepared);
void surroundings_free(struct surroundings *surroundings);

/** Seconds that it took to prepare what there is. */
double prepared_seconds(const struct lk_scene *scene);

/** What upload() is to take, with the BVH in these of the layouts that were prepared. */
struct upload_source prepared_source(const struct lk_scene *scene, unsigned layouts);

#endif
