/**
 * @file
 * How noisy a picture is, and which pixels go on until it is less so.
 *
 * The error of a tile, 256 consecutive pixels in Z-order, is the root mean square over its pixels
 * and channels of what they are off, relative to the root mean square of their values, or to a
 * tenth of the picture's mean where that is more. The noise of a picture is the error that one tile
 * in a hundred exceeds.
 *
 * Samples are taken in rounds that raise the samples of a pixel along 1, 8, 16, 32, 48, 64, 96,
 * 128, 192, ... After one, the samples before it and those of it are two estimates of a pixel; from
 * their difference comes the error of the two together (as from two buffers: F. Rousselle et al.,
 * "Adaptive Rendering with Non-Local Means Filtering", 2012, section 4.1). Spread samples complete
 * each other, so that it is told a little too large.
 *
 * Pixels whose error is above the one asked for go on. They do so by halves of a tile, the even or
 * the odd ones in that order, and a half goes by the error of its sibling, with which it shares no
 * random number: pixels that stopped by their own samples would keep those that happen to look
 * better than they are. What bias is left is of second order: how long a sibling goes on depends on
 * the half, and the end of a render on all pixels. Where one sample in 64 is 64 and the others are
 * black, a noise of 0.5 changes the mean by (0.02 +- 0.04) %; by their own samples it is 0.22 %.
 * It is more where a half's first samples hardly see what makes its noise: where one in 2048 is
 * 2048, and 16 are taken, the picture is 12 % too dark. For the same reason the error that is told
 * of a half is not one that it was chosen for.
 *
 * On two cores Sponza has a noise of 0.31 after 5.3 s, and with equally many samples everywhere
 * after 9.7 s; the Cornell box one of 0.15 after 1.4 s, and after 4.5 s. An H100 has 0.05 in Sponza
 * after 1.0 s, and with equally many samples after 2.2 s.
 */
#ifndef FILM_NOISE_H
#define FILM_NOISE_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "film/canvas.h"
#include "film/sequence.h"

/** What is known of half a tile, mean over pixels and channels. */
struct noise_half {
    double variance;  // of a pixel's mean
    double square;    // of a pixel's mean; what of it is noise is the variance
    double mean;      // of a pixel
    uint32_t samples; // of each pixel, when this was measured; 0: never
    bool goes_on;     // in the round
};

/** All zero is a valid empty one. */
struct noise {
    struct noise_half *halves; // [2 * tile_count]; owned
    double *errors;            // [tile_count] scratch; owned
    float *before;             // [3 * pixel_count] sums when the pixel's last round began; owned
    uint32_t *places;          // [pixel_count] pixels of the round, if they are not all; owned
    uint32_t pixel_count, tile_count;
    struct span round; // the last
    double asked;      // noise
    double reached;    // negative until it is estimated
};

/** @param asked  Noise to end with, > 0. @retval STATUS_NO_MEMORY */
enum status noise_create(struct noise *out, uint32_t pixel_count, double asked);

/**
 * Decides on the next round.
 *
 * @param canvas    With all of the last round.
 * @param most      Samples that no pixel is to have more of.
 * @param[out] out  The round; its places are borrowed until the next call.
 * @return False if the noise is as low as asked, or no pixel may go on.
 */
bool noise_next(struct noise *noise, const struct canvas *canvas, uint64_t most, struct span *out);

/** Estimates the noise of a canvas that may have a part of the last round. Negative if it cannot be
 * estimated: no pixel has more than 8 samples. */
double noise_estimate(const struct noise *noise, const struct canvas *canvas);

void noise_free(struct noise *noise);

/** Log2 of the pixels of a tile. */
#define NOISE_TILE_SHIFT 8u

/** The least that the mean square of a tile's values is taken for in a picture of that mean. */
double noise_dark_square(double mean);

/** The noise of tiles with these squared errors, [count] >= 1; sorts them. */
double noise_of_tiles(double *squared_errors, uint32_t count);

#endif
