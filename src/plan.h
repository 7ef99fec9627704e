/**
 * @file
 * What a render takes on a device, before it is taken.
 */
#ifndef PLAN_H
#define PLAN_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "device/gpu.h"
#include "engine.h"
#include "shared/camera.h"
#include "shared/settings.h"

/** What the kernels are told of the settings; what they are told of the scene is left 0. */
struct settings plan_kernel_settings(const struct lk_settings *settings);

/**
 * Counts what a prepared scene holds, with rays and film for this camera and queue.
 *
 * @param settings  With textures not auto. A queue of 0 asks for default_queue; no queue is longer
 * than the work.
 * @param layouts   Of the BVH, those that are there: the sum of 1 << LK_BVH_....
 */
void plan_describe(struct lk_scene_info *out, const struct lk_scene *scene,
                   const struct lk_settings *settings, unsigned layouts,
                   const struct camera *camera, uint32_t default_queue);

/** Whether the whole queue finds room beside these layouts of the BVH. */
bool plan_fits(const struct lk_settings *settings, const struct lk_scene *scene, unsigned layouts,
               const struct camera *camera, const struct gpu_info *info);

/**
 * Finds the longest queue that fits, sets it, and describes the scene with it.
 *
 * @param settings  Of this device, without any "auto".
 * @retval STATUS_NO_MEMORY  None fits; names the three largest users.
 */
enum status plan_memory(struct lk_scene_info *out, struct lk_settings *settings,
                        const struct lk_scene *scene, unsigned layouts, const struct camera *camera,
                        const struct gpu_info *info);

#endif
