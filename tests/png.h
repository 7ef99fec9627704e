/**
 * @file
 * Writes PNG bytes for textures that a test makes: 8-bit RGBA, zlib blocks that are stored, not
 * compressed.
 */
#ifndef TESTS_PNG_H
#define TESTS_PNG_H

#include <stddef.h>
#include <stdint.h>

/**
 * Encodes an image.
 *
 * @param[out] size  Bytes returned.
 * @param rgba       [width * height * 4], rows from the top; a row takes less than 64 KiB.
 * @return           The file's bytes, for free(); NULL if there is no memory.
 */
uint8_t *png_encode(size_t *size, const uint8_t *rgba, uint32_t width, uint32_t height);

#endif
