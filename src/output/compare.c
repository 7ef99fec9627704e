#include "output/compare.h"

#include <math.h>

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
