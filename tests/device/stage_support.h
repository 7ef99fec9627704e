/**
 * @file
 * What tests of whole stages share: a wavefront of a fixed size whose queue and counters the test
 * writes itself.
 */
#ifndef TESTS_DEVICE_STAGE_SUPPORT_H
#define TESTS_DEVICE_STAGE_SUPPORT_H

#include <assert.h>
#include <stdint.h>
#include <stdlib.h>

#include "pipeline/stages.h"
#include "prep/prep_support.h"
#include "support.h"

/** Makes a wavefront of `capacity` paths for `material_count` materials, sort's buffers included.
 */
static inline struct wavefront make_wavefront(struct gpu *gpu, uint32_t capacity,
                                              uint32_t material_count)
{
    const struct settings settings = {.depth = 2, .material_count = material_count};
    const struct camera camera = {.width = 1, .height = 1};
    const uint4 points[16] = {{0}};
    struct wavefront wavefront;
    assert(wavefront_points_size(&settings) <= sizeof(points));
    assert_ok(wavefront_create(&wavefront, gpu, capacity, &settings, &camera, points, true));
    return wavefront;
}

/** Fills queue[0 .. count) with distinct slots below `capacity`, in any order. */
static inline void make_queue(uint32_t *queue, uint32_t count, uint32_t capacity, uint64_t *seed)
{
    uint32_t *all = malloc(capacity * sizeof(*all));
    for (uint32_t i = 0; i < capacity; i++)
        all[i] = i;
    for (uint32_t i = 0; i < count; i++) {
        const uint32_t j = i + (uint32_t)(random_unit(seed) * (capacity - i));
        queue[i] = all[j];
        all[j] = all[i];
    }
    free(all);
}

/** Sets the counters of all bounces to 0, but for `active` of this one. */
static inline void write_counters(struct gpu *gpu, const struct wavefront *wavefront,
                                  uint32_t bounce, uint32_t active)
{
    struct counters *counters = calloc(wavefront->bounce_count, sizeof(*counters));
    counters[bounce].active = active;
    assert_ok(buffer_write(gpu, &wavefront->counters, counters,
                           wavefront->bounce_count * sizeof(*counters)));
    free(counters);
}

#endif
