/**
 * @file
 * What the tests that render share: the device, settings, and means with their standard errors.
 *
 * LIGHTKILN_TEST_DEVICE names the device (as lk_settings.device). LIGHTKILN_TEST_TRACE ("simple",
 * "persistent"), LIGHTKILN_TEST_BVH ("binary", "wide", "quad", "compressed") and
 * LIGHTKILN_TEST_BVH_BUILD
 * ("thesis") force a variant; without them the engine chooses.
 */
#ifndef TESTS_RENDER_SUPPORT_H
#define TESTS_RENDER_SUPPORT_H

#include <stdbool.h>
#include <stdint.h>

#include "lightkiln/lightkiln.h"

/** A mean and how far off it may be by chance. */
struct estimate {
    double mean;
    double error; // standard error of the mean
};

/** A colour. */
struct rgb {
    double v[3];
};

/** Skips the running test, saying so, if no OpenCL device is there. */
void skip_without_device(void);

/** The defaults, on the device to be tested, at this size. */
struct lk_settings test_settings(uint32_t width, uint32_t height, uint32_t spp);

/** Renders; fails the running test if that fails. The image is for lk_image_free(). */
struct lk_image *render(struct lk_scene *scene, const struct lk_settings *settings);

/** Mean over pixels and channels. */
double image_mean(const struct lk_image *image);

/** Renders and returns the mean over pixels and channels. */
double render_mean(struct lk_scene *scene, const struct lk_settings *settings);

/** Renders and returns the mean of each channel. */
struct rgb render_rgb(struct lk_scene *scene, const struct lk_settings *settings);

/** Renders and estimates the mean from the pixels, which must all look at the same: as where the
 * camera sees a point. */
struct estimate estimate_point(struct lk_scene *scene, const struct lk_settings *settings);

/** Renders with the seeds 1 .. count and estimates the mean over pixels and channels from them. */
struct estimate estimate_image(struct lk_scene *scene, const struct lk_settings *settings,
                               uint32_t count);

/** Mean and standard error of independent values [count], count >= 2. */
struct estimate estimate_values(const double *values, uint32_t count);

/** The images are equal, bit by bit. */
bool is_same_image(const struct lk_image *a, const struct lk_image *b);

/**
 * Fails the running test unless the estimate is `exact`, within four standard errors and `relative`
 * of it.
 *
 * @param what  Names the case in the message.
 */
void assert_agrees(const char *what, struct estimate estimate, double exact, double relative);

/** Fails the running test unless two estimates agree within four standard errors of their
 * difference. */
void assert_same_mean(const char *what, struct estimate a, struct estimate b);

#endif
