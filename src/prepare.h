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
 * Prepares a scene for these settings, unless it already is. Fails as the modules of prep/ do.
 *
 * @param settings  split_threshold, leaf_size and light_sampler (not auto) are looked at.
 */
enum status prepare_scene(struct lk_scene *scene, const struct lk_settings *settings);

/** Releases what was prepared. Safe on an unprepared one. */
void prepared_free(struct prepared *prepared);

/** What upload() is to take. */
struct upload_source prepared_source(const struct prepared *prepared);

#endif
