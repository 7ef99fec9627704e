/**
 * @file
 * Chooses a camera and turns it into what raygen reads.
 */
#ifndef PREP_CAMERA_H
#define PREP_CAMERA_H

#include <stdint.h>

#include "core/status.h"
#include "prep/flatten.h"
#include "scene/scene.h"
#include "shared/camera.h"

/**
 * Chooses a camera by its name, its node's name or its index, and the size of the image.
 *
 * A scene without cameras gets a view that frames it all, and a warning that says so. A size left
 * open is 1024 wide and as high as the camera's aspect asks, 16:9 if it does not; a given width or
 * height decides the other. Where both are given, the vertical field of view stays and the
 * horizontal one follows.
 *
 * @param[out] out  All of it.
 * @param selector  NULL: the first camera.
 * @param width, height  0: open.
 * @retval STATUS_USAGE  No camera answers to the selector; names those there are.
 */
enum status camera_build(struct camera *out, const struct scene *scene,
                         const struct geometry *geometry, const char *selector, uint32_t width,
                         uint32_t height);

#endif
