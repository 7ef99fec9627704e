/**
 * @file
 * The canvas: what the host knows of the picture so far. Films on devices begin with a part of it
 * and give that part back.
 */
#ifndef FILM_CANVAS_H
#define FILM_CANVAS_H

#include <stdint.h>

#include "core/status.h"
#include "shared/film.h"

/** Pixels in Z-order. All zero is a valid empty one. */
struct canvas {
    struct film_pixel *pixels; // [width * height]; owned
    uint32_t *samples;         // [width * height] in each sum; owned
    uint32_t width, height;
};

/** Makes a canvas without any samples. @retval STATUS_NO_MEMORY */
enum status canvas_create(struct canvas *out, uint32_t width, uint32_t height);

/** Samples of all pixels. */
uint64_t canvas_paths(const struct canvas *canvas);

/**
 * Makes the picture: the mean of every pixel's samples.
 *
 * @param[out] rgb  [width * height * 3], rows from the top; a pixel without samples is black.
 */
void canvas_resolve(const struct canvas *canvas, float *rgb);

void canvas_free(struct canvas *canvas);

#endif
