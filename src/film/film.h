/**
 * @file
 * The film: sums the paths of each pixel on the device, and makes pixels of the sums.
 */
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include <stdint.h>

#include "core/status.h"
#include "device/program.h"
#include "film/sequence.h"
#include "pipeline/wavefront.h"

/** All zero is a valid empty one. */
struct film {
    struct kernel kernel;
    struct buffer pixels; // struct film_pixel [width * height], in Z-order
    uint32_t width, height;
    uint32_t built; // programs compiled from source
};

/** Bytes that a pixel takes on the device. */
uint64_t film_pixel_size(void);

/** Makes an empty film. Fails as buffer_create() and kernel_build(). */
enum status film_create(struct film *out, struct gpu *gpu, uint32_t width, uint32_t height,
                        const struct program_options *options);

/** Enqueues the adding of a batch's finished paths. */
enum status film_enqueue(const struct film *film, struct gpu *gpu,
                         const struct wavefront *wavefront, const struct batch *batch);

/**
 * Reads the film: the mean of every pixel's samples.
 *
 * @param rgb       [width * height * 3], rows from the top; a pixel without samples is black.
 * @param sequence  Where the render stands.
 */
enum status film_resolve(const struct film *film, struct gpu *gpu, float *rgb,
                         const struct sequence *sequence);

void film_free(struct gpu *gpu, struct film *film);

#endif
