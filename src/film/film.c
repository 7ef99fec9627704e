#include "film/film.h"

#include <stdlib.h>

#include "shared/film.h"
#include "shared/zorder.h"

uint64_t film_pixel_size(void)
{
    return sizeof(struct film_pixel);
}

enum status film_create(struct film *out, struct gpu *gpu, uint32_t width, uint32_t height,
                        const struct program_options *options)
{
    struct film film = {.width = width, .height = height};
    const size_t size = (size_t)width * height * sizeof(struct film_pixel);
    enum status status = buffer_create(&film.pixels, gpu, size, NULL, "film");
    if (status == STATUS_OK)
        status = buffer_clear(gpu, &film.pixels);
    if (status == STATUS_OK)
        status = kernel_build(&film.kernel, gpu, "film", options, &film.built);
    if (status != STATUS_OK) {
        film_free(gpu, &film);
        return status;
    }
    *out = film;
    return STATUS_OK;
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

enum status film_resolve(const struct film *film, struct gpu *gpu, float *rgb,
                         const struct sequence *sequence)
{
    const uint32_t pixel_count = film->width * film->height;
    struct film_pixel *pixels = malloc(pixel_count * sizeof(*pixels));
    if (pixels == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to read %u pixels", pixel_count);
    const enum status status =
        buffer_read(gpu, &film->pixels, pixels, pixel_count * sizeof(*pixels));
    for (uint32_t place = 0; place < pixel_count && status == STATUS_OK; place++) {
        const uint64_t samples = sequence_samples(sequence, place);
        const double scale = samples > 0 ? 1.0 / (double)samples : 0.0;
        const struct film_pixel *from = &pixels[place];
        float *to = &rgb[3 * (size_t)zorder_pixel(place, film->width, film->height)];
        to[0] = (float)(((double)from->sum.x - from->carry.x) * scale);
        to[1] = (float)(((double)from->sum.y - from->carry.y) * scale);
        to[2] = (float)(((double)from->sum.z - from->carry.z) * scale);
    }
    free(pixels);
    return status;
}

void film_free(struct gpu *gpu, struct film *film)
{
    kernel_free(&film->kernel);
    buffer_free(gpu, &film->pixels);
    *film = (struct film){0};
}
