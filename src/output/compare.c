#include "output/compare.h"

#include <math.h>
#include <stdlib.h>

#include "film/noise.h"
#include "shared/zorder.h"

// Sums over all values that count.
struct sums {
    double squared, relative; // differences
    double image[3], reference[3];
    uint64_t counts[3];
    double peak; // largest value of the reference
};

static void finish(struct lk_comparison *out, const struct sums *sums, uint64_t pixel_count)
{
    uint64_t count = 0;
    for (int i = 0; i < 3; i++) {
        const double n = sums->counts[i] > 0 ? (double)sums->counts[i] : 1.0;
        out->mean[i] = sums->image[i] / n;
        out->reference_mean[i] = sums->reference[i] / n;
        count += sums->counts[i];
    }
    const double n = count > 0 ? (double)count : 1.0;
    out->variance = sums->squared / (pixel_count > 0 ? (double)pixel_count : 1.0);
    out->rmse = sqrt(sums->squared / n);
    out->relative_mse = sums->relative / n;
    out->psnr_db = out->rmse > 0.0 ? 20.0 * log10(sums->peak / out->rmse) : (double)INFINITY;
}

void compare_images(struct lk_comparison *out, float *difference, const float *image,
                    const float *reference, uint32_t width, uint32_t height)
{
    struct sums sums = {0};
    *out = (struct lk_comparison){0};

    const uint64_t pixel_count = (uint64_t)width * height;
    for (uint64_t i = 0; i < pixel_count * 3; i++) {
        if (difference != NULL)
            difference[i] = 0.0f;
        if (!isfinite(image[i]) || !isfinite(reference[i])) {
            out->not_finite++;
            continue;
        }
        const double r = (double)reference[i];
        const double d = (double)image[i] - r;
        sums.squared += d * d;
        sums.relative += d * d / (r * r + 0.01);
        sums.image[i % 3] += (double)image[i];
        sums.reference[i % 3] += r;
        sums.counts[i % 3]++;
        sums.peak = fmax(sums.peak, r);
        if (difference != NULL)
            difference[i] = (float)fabs(d);
        if (fabs(d) > out->maximum) {
            out->maximum = fabs(d);
            out->maximum_x = (uint32_t)(i / 3 % width);
            out->maximum_y = (uint32_t)(i / 3 / width);
        }
    }
    finish(out, &sums, pixel_count);
}

enum status compare_noise(double *out, const float *image, const float *reference, uint32_t width,
                          uint32_t height)
{
    const uint32_t pixel_count = width * height;
    const uint32_t tile_count = ((pixel_count - 1) >> NOISE_TILE_SHIFT) + 1;
    double *errors = calloc(tile_count, 2 * sizeof(*errors)); // of tiles, then squares of values
    if (errors == NULL)
        return status_fail(STATUS_NO_MEMORY, "not enough memory to compare %u pixels", pixel_count);
    double *squares = errors + tile_count;
    double mean = 0.0;
    double count = 0.0;
    for (uint32_t place = 0; place < pixel_count; place++) {
        const size_t first = 3 * (size_t)zorder_pixel(place, width, height);
        for (size_t i = first; i < first + 3; i++) {
            if (!isfinite(image[i]) || !isfinite(reference[i]))
                continue;
            const double r = (double)reference[i];
            const double d = (double)image[i] - r;
            errors[place >> NOISE_TILE_SHIFT] += d * d;
            squares[place >> NOISE_TILE_SHIFT] += r * r;
            mean += r;
            count += 1.0;
        }
    }
    const double dark = noise_dark_square(mean / fmax(count, 1.0));
    for (uint32_t tile = 0; tile < tile_count; tile++) {
        const uint32_t left = pixel_count - (tile << NOISE_TILE_SHIFT);
        const uint32_t size = left < 1u << NOISE_TILE_SHIFT ? left : 1u << NOISE_TILE_SHIFT;
        errors[tile] /= fmax(squares[tile], 3.0 * size * dark);
    }
    *out = noise_of_tiles(errors, tile_count);
    free(errors);
    return STATUS_OK;
}
