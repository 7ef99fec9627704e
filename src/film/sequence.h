/**
 * @file
 * The order in which the paths of a render, or of a part of it, are taken: in passes over the
 * pixels, each with a power of two of samples for every pixel, side by side (struct batch).
 *
 * The order changes nothing in the picture, since a path depends on pixel and sample alone, and a
 * pixel's samples always come one after the other. Even passes double as samples do, until they
 * have 2^PASS_SHIFT_MAX: a picture stopped at any time has at most about twice as many samples in
 * one pixel as in another, and every pixel has one soon.
 */
#ifndef FILM_SEQUENCE_H
#define FILM_SEQUENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "shared/path.h"

/** A part of the work: pixels, and samples of each. */
struct span {
    uint32_t first_pixel, pixel_count; // consecutive in Z-order, unless
    uint64_t first_sample, end_sample; // those before are taken; end UINT64_MAX: without end
    const uint32_t *places;            // [pixel_count] in Z-order tell them; NULL: none. Borrowed
};

/** The place in Z-order of a span's pixel. */
static inline uint32_t span_place(const struct span *span, uint32_t index)
{
    return span->places != NULL ? span->places[index] : span->first_pixel + index;
}

/** Where the work on a span stands. Not to be changed but by the functions below. */
struct sequence {
    struct span span;
    uint64_t first_sample; // of the pass; all before are taken
    uint64_t done;         // paths of the pass that are taken
    uint32_t sample_shift; // log2 of the samples of each pixel in the pass
    bool even;             // passes grow as samples do, else they are large from the start
};

/** Begins one. */
void sequence_begin(struct sequence *sequence, const struct span *span, bool even);

/** The next batch, of at most so many paths (>= 1). Not when it has ended. */
struct batch sequence_batch(const struct sequence *sequence, uint32_t paths);

/** Counts that batch as taken. */
void sequence_advance(struct sequence *sequence, const struct batch *batch);

/** Whether every sample was taken. */
bool sequence_ended(const struct sequence *sequence);

/** Paths of the span that were taken. */
uint64_t sequence_paths(const struct sequence *sequence);

/** Samples taken of a pixel, by its index in the span: with those before the span. */
uint64_t sequence_samples(const struct sequence *sequence, uint32_t index);

#endif
