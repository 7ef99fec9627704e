/**
 * @file
 * How far an image is from a reference, in the measures of struct lk_comparison.
 */
#ifndef OUTPUT_COMPARE_H
#define OUTPUT_COMPARE_H

#include <stddef.h>
#include <stdint.h>

#include "core/status.h"
#include "lightkiln/image.h"

/**
 * Compares. Values that are not finite in one of the images are left out of every sum and counted.
 *
 * @param[out] out         All of it is written.
 * @param[out] difference  NULL, or [width * height * 3]: absolute differences, 0 where left out.
 * @param image, reference [width * height * 3].
 */
void compare_images(struct lk_comparison *out, float *difference, const float *image,
                    const float *reference, uint32_t width, uint32_t height);

/** Measures the noise of an image, as film/noise.h has it; other parameters as above.
 * @retval STATUS_NO_MEMORY */
enum status compare_noise(double *out, const float *image, const float *reference, uint32_t width,
                          uint32_t height);

#endif
