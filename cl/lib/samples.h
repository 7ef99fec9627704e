/**
 * @file
 * The numbers that paths are made of, a pure function of (seed, pixel, sample, dimension).
 *
 * A sample's point comes from the table of its block of dimensions (src/prep/samples.h) and is
 * shifted by exclusive or with random bits that pixel and dimension have alone: every sample by
 * itself is uniform, samples of a pixel are spread evenly among each other, pixels and dimensions
 * are independent. Numbers past the table's end begin it anew under another shift; with a table of
 * one point of zeros every sample is random.
 */
#ifndef LIB_SAMPLES_H
#define LIB_SAMPLES_H

#include "shared/path.h"
#include "shared/rng.h"
#include "shared/settings.h"

// Four numbers of 32 bits.
//
//   pixel   in Z-order
//   number  in the sequence, the sample's but for several draws of one kind
//   index   tells apart what shares a block
static inline uint4 samples_draw(__constant struct settings *settings,
                                 __global const uint4 *restrict points, const uint pixel,
                                 const uint number, const uint bounce, const uint use,
                                 const uint index)
{
    const uint shift = settings->point_shift;
    const uint4 turn =
        rng_bits(settings->seed, pixel, number >> shift, rng_dimension(bounce, use, index));
    const uint4 point = points[(rng_block(bounce, use) << shift) + (number & ((1u << shift) - 1u))];
    return point ^ turn;
}

// Whose path a slot holds, its pixel in the image's Z-order.
//
//   places  in that order, of the pixels that batches count through
static inline struct path_place samples_place(const struct batch batch,
                                              __global const uint *restrict places, const uint slot)
{
    struct path_place place = batch_place(batch, slot);
    place.pixel = places[place.pixel];
    return place;
}

#endif
