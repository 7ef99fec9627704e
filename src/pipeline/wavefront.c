#include "pipeline/wavefront.h"

#include <stdlib.h>

#include "shared/ray.h"
#include "shared/rng.h"

// Scratch bytes per path: 16 digits of each tile in sort, and no tile is smaller than 16 elements.
#define SORT_TOTALS 4u

uint64_t wavefront_path_size(bool textures_bound)
{
    const uint64_t words = textures_bound ? 6 : 2;
    return sizeof(struct ray) + sizeof(struct hit) + sizeof(struct path) +
           words * sizeof(uint32_t) + (textures_bound ? SORT_TOTALS : 0);
}

uint64_t wavefront_points_size(const struct settings *settings)
{
    return ((uint64_t)rng_block_count(settings->depth) << settings->point_shift) * sizeof(uint4);
}

uint64_t wavefront_places_size(uint64_t pixel_count)
{
    return pixel_count * sizeof(uint32_t);
}

enum status wavefront_set_places(const struct wavefront *wavefront, struct gpu *gpu,
                                 const uint32_t *places, uint32_t count)
{
    return buffer_write(gpu, &wavefront->places, places, count * sizeof(*places));
}

static enum status set_all_places(const struct wavefront *wavefront, struct gpu *gpu,
                                  uint32_t count)
{
    uint32_t *places = malloc(count * sizeof(*places));
    if (places == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for the places of %u pixels", count);
    for (uint32_t place = 0; place < count; place++)
        places[place] = place;
    const enum status status = wavefront_set_places(wavefront, gpu, places, count);
    free(places);
    return status;
}

enum status wavefront_create(struct wavefront *out, struct gpu *gpu, uint32_t capacity,
                             const struct settings *settings, const struct camera *camera,
                             const uint4 *points, bool textures_bound)
{
    struct wavefront w = {.capacity = capacity, .bounce_count = settings->depth + 2};
    const uint32_t pixels = camera->width * camera->height;
    const size_t words = capacity * sizeof(uint32_t);
    const size_t sort_words = textures_bound ? words : 0;
    const size_t totals = capacity * (size_t)SORT_TOTALS + 64 * sizeof(uint32_t);
    const struct {
        struct buffer *buffer;
        size_t size;
        const void *data;
        const char *name;
    } table[] = {
        {&w.settings, sizeof(*settings), settings, "settings"},
        {&w.camera, sizeof(*camera), camera, "camera"},
        {&w.points, wavefront_points_size(settings), points, "points of samples"},
        {&w.places, wavefront_places_size(pixels), NULL, "places of pixels"},
        {&w.rays, capacity * sizeof(struct ray), NULL, "rays"},
        {&w.hits, capacity * sizeof(struct hit), NULL, "hits"},
        {&w.paths, capacity * sizeof(struct path), NULL, "paths"},
        {&w.queue[0], words, NULL, "ray queue"},
        {&w.queue[1], words, NULL, "ray queue"},
        {&w.counters, w.bounce_count * sizeof(struct counters), NULL, "counters"},
        {&w.totals, textures_bound ? totals : 0, NULL, "scan totals"},
        {&w.keys[0], sort_words, NULL, "sort keys"},
        {&w.keys[1], sort_words, NULL, "sort keys"},
        {&w.slots[0], sort_words, NULL, "sorted slots"},
        {&w.slots[1], sort_words, NULL, "sorted slots"},
        {&w.ranges, textures_bound ? (settings->material_count + 2) * sizeof(uint32_t) : 0, NULL,
         "material ranges"},
    };
    for (size_t i = 0; i < sizeof(table) / sizeof(table[0]); i++) {
        const enum status status =
            buffer_create(table[i].buffer, gpu, table[i].size, table[i].data, table[i].name);
        if (status != STATUS_OK) {
            wavefront_free(gpu, &w);
            return status;
        }
    }
    const enum status status = set_all_places(&w, gpu, pixels);
    if (status != STATUS_OK) {
        wavefront_free(gpu, &w);
        return status;
    }
    *out = w;
    return STATUS_OK;
}

void wavefront_free(struct gpu *gpu, struct wavefront *w)
{
    buffer_free(gpu, &w->ranges);
    for (int i = 0; i < 2; i++) {
        buffer_free(gpu, &w->slots[i]);
        buffer_free(gpu, &w->keys[i]);
        buffer_free(gpu, &w->queue[i]);
    }
    buffer_free(gpu, &w->totals);
    buffer_free(gpu, &w->counters);
    buffer_free(gpu, &w->paths);
    buffer_free(gpu, &w->hits);
    buffer_free(gpu, &w->rays);
    buffer_free(gpu, &w->places);
    buffer_free(gpu, &w->points);
    buffer_free(gpu, &w->camera);
    buffer_free(gpu, &w->settings);
    *w = (struct wavefront){0};
}
