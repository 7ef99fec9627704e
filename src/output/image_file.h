/**
 * @file
 * Image files as results: what their extension asks for, and what goes into their header.
 *
 * Header: Software, lightkiln:seed, lightkiln:settings (those that shape the picture, as JSON),
 * lightkiln:device, lightkiln:samples_per_pixel, lightkiln:units. Neither dates nor seconds, since
 * equal renders must be equal files.
 */
#ifndef OUTPUT_IMAGE_FILE_H
#define OUTPUT_IMAGE_FILE_H

#include <stdbool.h>

#include "core/status.h"
#include "film/tonemap.h"
#include "lightkiln/render.h"

enum image_kind {
    IMAGE_LINEAR, // float: .exr .hdr .tif .tiff
    IMAGE_DISPLAY // 8 bits: .png .jpg .jpeg
};

/** Finds the kind by the extension. STATUS_USAGE if it is none of these. */
enum status image_file_kind(enum image_kind *out, const char *path);

/**
 * Writes an image; the display transform is applied to 8-bit files only.
 *
 * @param rgb   [width * height * 3], linear, rows from the top.
 * @param info  What the header tells; NULL: nothing but the program.
 * @retval STATUS_USAGE, STATUS_WRITE, STATUS_NO_MEMORY
 */
enum status image_file_write(const char *path, const float *rgb, uint32_t width, uint32_t height,
                             const struct lk_render_info *info, const char *version,
                             float exposure_ev, enum tonemap tonemap);

#endif
