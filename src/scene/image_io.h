/**
 * @file
 * Image files in and out, behind OpenImageIO.
 */
#ifndef SCENE_IMAGE_IO_H
#define SCENE_IMAGE_IO_H

#include <stddef.h>
#include <stdint.h>

#include "core/status.h"

/** Text that goes into an image's header. */
struct image_attribute {
    const char *name;  // borrowed
    const char *value; // borrowed
};

/**
 * Decodes an image in memory (PNG, JPEG, WebP: found by its first bytes) to 8-bit RGBA, rows from
 * the top. Grey becomes RGB, missing alpha 255, 16 bits are rounded to 8; no colour conversion, no
 * premultiplication.
 *
 * @param[out] rgba  [width * height * 4], to be released with free().
 * @param name       For messages.
 * @retval STATUS_FORMAT     Not an image, or a broken one, or larger than 65535 on a side.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status image_decode(uint8_t **rgba, uint32_t *width, uint32_t *height, const void *bytes,
                         size_t size, const char *name);

/**
 * Reads a file's R, G and B as float; a grey file gives three times the same. 8-bit files are
 * decoded from sRGB.
 *
 * @param[out] rgb  [width * height * 3], rows from the top, to be released with free().
 * @retval STATUS_IO      It cannot be opened.
 * @retval STATUS_FORMAT  It is not an image, or has no colour.
 */
enum status image_read_rgb(float **rgb, uint32_t *width, uint32_t *height, const char *path);

/**
 * Writes RGB in the format that the name's extension asks for: .exr and .hdr float, .tif float,
 * .png and .jpg 8 bits (values are taken as display-referred 0 .. 1 there and only quantised). The
 * file appears whole or not at all. No dates are written.
 *
 * @param rgb         [width * height * 3], rows from the top.
 * @param attributes  [attribute_count], for formats that hold them.
 * @retval STATUS_USAGE  The extension is not one of .exr .hdr .png .jpg .jpeg .tif .tiff.
 * @retval STATUS_WRITE  The file cannot be written; an old one is left alone.
 */
enum status image_write_rgb(const char *path, const float *rgb, uint32_t width, uint32_t height,
                            const struct image_attribute *attributes, size_t attribute_count);

#endif
