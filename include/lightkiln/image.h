/**
 * @file
 * Images: their pixels, their files, and how far two are apart.
 */
#ifndef LIGHTKILN_IMAGE_H
#define LIGHTKILN_IMAGE_H

#include <stdint.h>

#include "lightkiln/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** An image: rendered, with what is to be told about it (lightkiln/render.h), or read, or made.
 * Opaque. */
struct lk_image;

/** Width, height and pixels of an image: [width * height * 3] linear RGB, rows from the top.
 * Borrowed. */
LK_API const float *lk_image_pixels(const struct lk_image *image, uint32_t *width,
                                    uint32_t *height);

/** The curve of 8-bit files. */
enum lk_tonemap {
    LK_TONEMAP_AUTO, // aces for 8-bit files
    LK_TONEMAP_NONE,
    LK_TONEMAP_REINHARD,
    LK_TONEMAP_ACES
};

/** Display transform of 8-bit files; never touches the others. NULL where it is taken: exposure 0,
 * tonemap auto. */
struct lk_display {
    float exposure_ev; // stops
    enum lk_tonemap tonemap;
};

/**
 * Writes .exr, .hdr, .tif (linear float), .png or .jpg (8 bits, exposed, tone-mapped, sRGB). Whole
 * or not at all.
 *
 * @retval LK_USAGE  The extension is none of these.
 * @retval LK_WRITE  It cannot be written; an old file is left alone.
 */
LK_API enum lk_status lk_image_write(const struct lk_image *image, const char *path,
                                     const struct lk_display *display);

/** Checks that lk_image_write() knows the extension and may write there, before hours are spent.
 * LK_USAGE or LK_WRITE if not. */
LK_API enum lk_status lk_image_can_write(const char *path);

/** Reads an image file as linear RGB; 8-bit files are decoded from sRGB. @retval LK_IO, LK_FORMAT,
 * LK_UNSUPPORTED, LK_NO_MEMORY */
LK_API enum lk_status lk_image_read(struct lk_image **out, const char *path);

/**
 * Makes an image of one's own pixels.
 *
 * @param pixels  [width * height * 3] linear RGB, rows from the top; copied.
 * @retval LK_USAGE, LK_NO_MEMORY
 */
LK_API enum lk_status lk_image_create(struct lk_image **out, const float *pixels, uint32_t width,
                                      uint32_t height);

/** Releases it, and with it the info and the pixels. NULL is accepted. */
LK_API void lk_image_free(struct lk_image *image);

/** How far an image is from a reference; values are linear. */
struct lk_comparison {
    double variance; // thesis section 4.2.2: mean over pixels of the summed squared differences of
                     // R, G and B
    double rmse;     // root mean square over pixels and channels
    double relative_mse; // mean over pixels and channels of d^2 / (reference^2 + 0.01)
    double noise;        // as in struct lk_settings: what one tile in a hundred exceeds
    double psnr_db;      // with the reference's largest value as peak; infinite for equal images
    double maximum;      // largest absolute difference
    uint32_t maximum_x, maximum_y; // where
    double mean[3], reference_mean[3];
    uint64_t not_finite; // values of the image left out because they are not finite
};

/**
 * Compares two images of one size.
 *
 * @param[out] difference  NULL, or the absolute difference as an image, to be freed by the caller.
 * @retval LK_FORMAT  The sizes differ. @retval LK_NO_MEMORY
 */
LK_API enum lk_status lk_compare(struct lk_comparison *out, struct lk_image **difference,
                                 const struct lk_image *image, const struct lk_image *reference);

#ifdef __cplusplus
}
#endif

#endif
