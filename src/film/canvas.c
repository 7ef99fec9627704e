#include "film/canvas.h"

#include <stdlib.h>

#include "shared/zorder.h"

enum status canvas_create(struct canvas *out, uint32_t width, uint32_t height)
{
    const size_t count = (size_t)width * height;
    struct canvas canvas = {.width = width, .height = height};
    canvas.pixels = calloc(count, sizeof(*canvas.pixels));
    canvas.samples = calloc(count, sizeof(*canvas.samples));
    if (canvas.pixels == NULL || canvas.samples == NULL) {
        canvas_free(&canvas);
        return status_fail(STATUS_NO_MEMORY, "no memory for %zu pixels", count);
    }
    *out = canvas;
    return STATUS_OK;
}

uint64_t canvas_paths(const struct canvas *canvas)
{
    const size_t count = (size_t)canvas->width * canvas->height;
    uint64_t paths = 0;
    for (size_t place = 0; place < count; place++)
        paths += canvas->samples[place];
    return paths;
}

void canvas_resolve(const struct canvas *canvas, float *rgb)
{
    const uint32_t count = canvas->width * canvas->height;
    for (uint32_t place = 0; place < count; place++) {
        const uint32_t samples = canvas->samples[place];
        const double scale = samples > 0 ? 1.0 / (double)samples : 0.0;
        const struct film_pixel *from = &canvas->pixels[place];
        float *to = &rgb[3 * (size_t)zorder_pixel(place, canvas->width, canvas->height)];
        to[0] = (float)(((double)from->sum.x - from->carry.x) * scale);
        to[1] = (float)(((double)from->sum.y - from->carry.y) * scale);
        to[2] = (float)(((double)from->sum.z - from->carry.z) * scale);
    }
}

void canvas_free(struct canvas *canvas)
{
    free(canvas->samples);
    free(canvas->pixels);
    *canvas = (struct canvas){0};
}
