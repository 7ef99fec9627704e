/**
 * @file
 * The film: sums the paths of each pixel of a span on the device, where the canvas has them.
 */
#ifndef FILM_FILM_H
#define FILM_FILM_H

#include <stdint.h>

#include "core/status.h"
#include "device/program.h"
#include "film/canvas.h"
#include "film/sequence.h"
#include "pipeline/wavefront.h"

/** All zero is a valid empty one. */
struct film {
    struct kernel kernel;
    struct buffer pixels;    // struct film_pixel of a span's pixels
    struct film_pixel *rows; // the same on their way, of pixels that are not consecutive; owned
    uint32_t built;          // programs compiled from source
};

/** Bytes that a pixel takes on the device. */
uint64_t film_pixel_size(void);

/** Makes a film for spans of up to so many pixels. Fails as buffer_create() and kernel_build(). */
enum status film_create(struct film *out, struct gpu *gpu, uint32_t pixel_count,
                        const struct program_options *options);

/** Starts a span with the sums that the canvas has. */
enum status film_begin(const struct film *film, struct gpu *gpu, const struct canvas *canvas,
                       const struct span *span);

/** Enqueues the adding of a batch's finished paths. */
enum status film_enqueue(const struct film *film, struct gpu *gpu,
                         const struct wavefront *wavefront, const struct batch *batch);

/** Gives the canvas the span's sums, however far it has come. */
enum status film_end(const struct film *film, struct gpu *gpu, struct canvas *canvas,
                     const struct sequence *sequence);

void film_free(struct gpu *gpu, struct film *film);

#endif
