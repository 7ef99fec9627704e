#include "film/film.h"

#include <stdlib.h>

uint64_t film_pixel_size(void)
{
    return sizeof(struct film_pixel);
}

enum status film_create(struct film *out, struct gpu *gpu, uint32_t pixel_count,
                        const struct program_options *options)
{
    struct film film = {0};
    const size_t size = pixel_count * sizeof(struct film_pixel);
    film.rows = malloc(size);
    if (film.rows == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for a film of %u pixels", pixel_count);
    enum status status = buffer_create(&film.pixels, gpu, size, NULL, "film");
    if (status == STATUS_OK)
        status = kernel_build(&film.kernel, gpu, "film", options, &film.built);
    if (status != STATUS_OK) {
        film_free(gpu, &film);
        return status;
    }
    *out = film;
    return STATUS_OK;
}

enum status film_begin(const struct film *film, struct gpu *gpu, const struct canvas *canvas,
                       const struct span *span)
{
    if (span->first_sample == 0)
        return buffer_clear(gpu, &film->pixels);
    const struct film_pixel *rows = canvas->pixels + span->first_pixel;
    if (span->places != NULL) {
        for (uint32_t i = 0; i < span->pixel_count; i++)
            film->rows[i] = canvas->pixels[span->places[i]];
        rows = film->rows;
    }
    return buffer_write(gpu, &film->pixels, rows, span->pixel_count * sizeof(*rows));
}

enum status film_enqueue(const struct film *film, struct gpu *gpu,
                         const struct wavefront *wavefront, const struct batch *batch)
{
    const struct kernel_arg args[] = {
        ARG_VALUE(*batch),
        ARG_BUFFER(&wavefront->paths),
        ARG_BUFFER(&film->pixels),
    };
    const uint32_t touched = (batch->count >> batch->sample_shift) + 2; // two may be cut
    return kernel_enqueue(gpu, &film->kernel, args, 3,
                          touched < batch->pixel_count ? touched : batch->pixel_count);
}

enum status film_end(const struct film *film, struct gpu *gpu, struct canvas *canvas,
                     const struct sequence *sequence)
{
    const struct span *span = &sequence->span;
    struct film_pixel *rows = canvas->pixels + span->first_pixel;
    if (span->places != NULL)
        rows = film->rows;
    const enum status status =
        buffer_read(gpu, &film->pixels, rows, span->pixel_count * sizeof(*rows));
    if (status != STATUS_OK)
        return status;
    for (uint32_t i = 0; i < span->pixel_count; i++) {
        const uint32_t place = span_place(span, i);
        canvas->samples[place] = (uint32_t)sequence_samples(sequence, i);
        canvas->pixels[place] = rows[i];
    }
    return STATUS_OK;
}

void film_free(struct gpu *gpu, struct film *film)
{
    kernel_free(&film->kernel);
    buffer_free(gpu, &film->pixels);
    free(film->rows);
    *film = (struct film){0};
}
