/**
 * @file
 * The paths in flight: the buffers that stages hand to each other, and what all of them read.
 */
#ifndef PIPELINE_WAVEFRONT_H
#define PIPELINE_WAVEFRONT_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "device/buffer.h"
#include "shared/camera.h"
#include "shared/path.h"
#include "shared/settings.h"

/** All zero is a valid empty one. */
struct wavefront {
    struct buffer settings, camera;
    struct buffer points;            // of samples, by block
    struct buffer places;            // of the pixels that batches count through
    struct buffer rays, hits, paths; // [capacity] by slot; hits become shades in material
    struct buffer queue[2];          // [capacity] slots of this bounce and of the next
    struct buffer counters;          // [bounce_count]
    // Of sort; empty unless textures are bound.
    struct buffer keys[2], slots[2], ranges, totals;
    uint32_t capacity;     // paths
    uint32_t bounce_count; // sets of counters
};

/** Bytes that a path takes. */
uint64_t wavefront_path_size(bool textures_bound);

/** Bytes of the places of so many pixels. */
uint64_t wavefront_places_size(uint64_t pixel_count);

/** Bytes of the points of samples, prep/samples.h. */
uint64_t wavefront_points_size(const struct settings *settings);

/**
 * Makes the buffers for `capacity` paths.
 *
 * @param points  [rng_block_count(depth) << point_shift].
 * @retval STATUS_NO_MEMORY, STATUS_DEVICE
 */
enum status wavefront_create(struct wavefront *out, struct gpu *gpu, uint32_t capacity,
                             const struct settings *settings, const struct camera *camera,
                             const uint4 *points, bool textures_bound);

/**
 * Sets the pixels that batches count through, in place of all in Z-order.
 *
 * @param places  [count] in Z-order; at most the image's.
 */
enum status wavefront_set_places(const struct wavefront *wavefront, struct gpu *gpu,
                                 const uint32_t *places, uint32_t count);

void wavefront_free(struct gpu *gpu, struct wavefront *wavefront);

#endif
