/**
 * @file
 * lightkiln: path-traced global illumination for glTF levels on any OpenCL device.
 *
 * The whole of it on one page:
 *
 *     struct lk_settings settings;
 *     lk_settings_init(&settings);
 *     settings.spp = 256;
 *
 *     struct lk_scene *scene = NULL;
 *     struct lk_image *image = NULL;
 *     if (lk_scene_load(&scene, "level.glb") != LK_OK ||
 *         lk_render(&image, scene, &settings, NULL) != LK_OK ||
 *         lk_image_write(image, "level.exr", NULL) != LK_OK)
 *         fprintf(stderr, "%s\n", lk_error());
 *     lk_image_free(image);
 *     lk_scene_free(scene);
 *
 * Conventions. Every function that can fail returns an lk_status; its result goes through the first
 * parameter, on success only, and lk_error() then tells what went wrong, naming the file, mesh or
 * device. Metres, Y up, linear Rec. 709; light in the file's units (candela, lux, and cd/m2 for
 * radiance). Functions may be called from any thread, but one object from one at a time. Free
 * functions accept NULL.
 *
 * This header takes in the others, in the order in which a program meets them. Each stands alone.
 */
#ifndef LIGHTKILN_LIGHTKILN_H
#define LIGHTKILN_LIGHTKILN_H

#include "lightkiln/status.h"   // what went wrong, and what is said meanwhile
#include "lightkiln/scene.h"    // what a file says, and what it takes to render
#include "lightkiln/device.h"   // the OpenCL devices of this machine
#include "lightkiln/settings.h" // what a render can be asked for
#include "lightkiln/render.h"   // rendering, and what is told about it
#include "lightkiln/image.h"    // pixels, their files, and how far two images are apart
#include "lightkiln/tracer.h"   // rays of one's own

#endif
