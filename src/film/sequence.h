/**
 * @file
 * The order in which the paths of a render are taken: in passes over the image, each with a power
 * of two of samples for every pixel, side by side (struct batch).
 *
 * Passes double until they have PASS_SAMPLES_MAX, so that an image stopped at any time has at most
 * about twice as many samples in one pixel as in another, and every pixel has one soon.
 */
#ifndef FILM_SEQUENCE_H
#define FILM_SEQUENCE_H

#include <stdint.h>

#include "shared/path.h"

/** Where a render stands. Not to be changed but by the functions below. */
struct sequence {
    uint64_t spp;          // samples per pixel to take; 0: without end
    uint64_t first_sample; // of the pass; all before are taken
    uint64_t done;         // paths of the pass that are taken
    uint32_t pixel_count;
    uint32_t sample_shift; // log2 of the samples of each pixel in the pass
};

/** Begins one. */
void sequence_begin(struct sequence *sequence, uint32_t pixel_count, uint64_t spp);

/** The next batch, of at most so many paths (>= 1). Not when it has ended. */
struct batch sequence_batch(const struct sequence *sequence, uint32_t paths);

/** Counts that batch as taken. */
void sequence_advance(struct sequence *sequence, const struct batch *batch);

/** Whether every sample was taken. */
int sequence_ended(const struct sequence *sequence);

/** Paths taken. */
uint64_t sequence_paths(const struct sequence *sequence);

/** Samples taken of a pixel, by its place in Z-order. */
uint64_t sequence_samples(const struct sequence *sequence, uint32_t place);

#endif
