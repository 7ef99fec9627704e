// The thin part of the public API: what only hands on. Scenes, devices and rendering are
// engine.c's.

#include "lightkiln/lightkiln.h"

#include <stdlib.h>
#include <string.h>

#include "core/clock.h"
#include "core/file.h"
#include "core/json.h"
#include "core/log.h"
#include "core/status.h"
#include "engine.h"
#include "film/tonemap.h"
#include "output/compare.h"
#include "output/image_file.h"
#include "output/report.h"
#include "scene/image_io.h"
#include "version.h"

// The public enums are the inner ones by another name.
#define SAME(public, inner)                                                                        \
    _Static_assert((int)public == (int)inner, #public " and " #inner " must be equal")
SAME(LK_OK, STATUS_OK);
SAME(LK_NO_MEMORY, STATUS_NO_MEMORY);
SAME(LK_IO, STATUS_IO);
SAME(LK_WRITE, STATUS_WRITE);
SAME(LK_FORMAT, STATUS_FORMAT);
SAME(LK_UNSUPPORTED, STATUS_UNSUPPORTED);
SAME(LK_LIMIT, STATUS_LIMIT);
SAME(LK_NO_DEVICE, STATUS_NO_DEVICE);
SAME(LK_DEVICE, STATUS_DEVICE);
SAME(LK_USAGE, STATUS_USAGE);
SAME(LK_CANCELLED, STATUS_CANCELLED);
SAME(LK_LOG_ERROR, LOG_ERROR);
SAME(LK_LOG_WARNING, LOG_WARNING);
SAME(LK_LOG_INFO, LOG_INFO);
SAME(LK_LOG_DEBUG, LOG_DEBUG);

const char *lk_error(void)
{
    return status_message();
}

const char *lk_status_name(enum lk_status status)
{
    return status_name((enum status)status);
}

const char *lk_version(void)
{
    return LIGHTKILN_VERSION;
}

// ---- Messages

static lk_log_function *user_log; // NULL: stderr
static void *user_log_data;

static void pass_on(void *user, enum log_level level, const char *message)
{
    (void)user;
    user_log(user_log_data, (enum lk_log_level)level, message);
}

void lk_log_set(enum lk_log_level level, lk_log_function *function, void *user)
{
    user_log = function;
    user_log_data = user;
    log_set_level((enum log_level)level);
    log_set_function(function != NULL ? pass_on : NULL, NULL);
}

unsigned lk_warning_count(void)
{
    return log_warning_count();
}

// ---- Settings

void lk_settings_init(struct lk_settings *settings)
{
    *settings = (struct lk_settings){
        .spp = 64,
        .depth = 5,
        .roulette_depth = 2,
        .shadow_rays = 1,
        .env_strength = 1.0f,
        .sky_turbidity = 3.0f,
        .leaf_size = 8,
    };
}

// ---- Images

const struct lk_render_info *lk_image_info(const struct lk_image *image)
{
    return image->rendered ? &image->info : NULL;
}

const float *lk_image_pixels(const struct lk_image *image, uint32_t *width, uint32_t *height)
{
    *width = image->width;
    *height = image->height;
    return image->rgb;
}

static enum tonemap choose_tonemap(const struct lk_display *display)
{
    switch (display != NULL ? display->tonemap : LK_TONEMAP_AUTO) {
    case LK_TONEMAP_NONE:
        return TONEMAP_NONE;
    case LK_TONEMAP_REINHARD:
        return TONEMAP_REINHARD;
    case LK_TONEMAP_AUTO:
    case LK_TONEMAP_ACES:
        break;
    }
    return TONEMAP_ACES;
}

enum lk_status lk_image_write(const struct lk_image *image, const char *path,
                              const struct lk_display *display)
{
    const double begin_s = clock_seconds();
    const enum status status = image_file_write(
        path, image->rgb, image->width, image->height, lk_image_info(image), lk_version(),
        display != NULL ? display->exposure_ev : 0.0f, choose_tonemap(display));

    // The time is no part of the picture, so a const image may keep it; none lies in constant
    // memory.
    ((struct lk_image *)image)->write_s += clock_seconds() - begin_s;
    return (enum lk_status)status;
}

enum lk_status lk_image_can_write(const char *path)
{
    enum image_kind kind = IMAGE_LINEAR;
    enum status status = image_file_kind(&kind, path);
    if (status == STATUS_OK)
        status = file_check_writable(path);
    return (enum lk_status)status;
}

enum lk_status lk_image_read(struct lk_image **out, const char *path)
{
    struct lk_image *image = calloc(1, sizeof(*image));
    if (image == NULL)
        return (enum lk_status)status_fail(STATUS_NO_MEMORY, "%s: not enough memory", path);
    const enum status status = image_read_rgb(&image->rgb, &image->width, &image->height, path);
    if (status != STATUS_OK) {
        free(image);
        return (enum lk_status)status;
    }
    *out = image;
    return LK_OK;
}

enum lk_status lk_image_create(struct lk_image **out, const float *pixels, uint32_t width,
                               uint32_t height)
{
    const size_t size = (size_t)width * height * 3 * sizeof(*pixels);
    if (size == 0)
        return (enum lk_status)status_fail(STATUS_USAGE, "an image of %u x %u pixels", width,
                                           height);
    struct lk_image *image = calloc(1, sizeof(*image));
    float *rgb = malloc(size);
    if (image == NULL || rgb == NULL) {
        free(rgb);
        free(image);
        return (enum lk_status)status_fail(
            STATUS_NO_MEMORY, "not enough memory for an image of %u x %u", width, height);
    }
    memcpy(rgb, pixels, size);
    *image = (struct lk_image){.rgb = rgb, .width = width, .height = height};
    *out = image;
    return LK_OK;
}

void lk_image_free(struct lk_image *image)
{
    if (image == NULL)
        return;
    free((char *)image->info.settings.device);
    free((char *)image->info.settings.env);
    free((char *)image->info.settings.camera);
    free((char *)image->info.scene.file);
    free(image->rgb);
    free(image);
}

enum lk_status lk_report_write(const struct lk_image *image, const char *path)
{
    if (!image->rendered)
        return (enum lk_status)status_fail(STATUS_USAGE, "%s: only a rendered image has a report",
                                           path);
    struct json json = {0};
    enum status status = report_write(&json, &image->info, lk_version(), image->write_s);
    if (status == STATUS_OK)
        status = file_write(path, json.text, json.size);
    json_free(&json);
    return (enum lk_status)status;
}

// ---- Comparison

enum lk_status lk_compare(struct lk_comparison *out, struct lk_image **difference,
                          const struct lk_image *image, const struct lk_image *reference)
{
    if (image->width != reference->width || image->height != reference->height)
        return (enum lk_status)status_fail(
            STATUS_FORMAT,
            "the image is %u x %u and the reference %u x %u; they must be of one size",
            image->width, image->height, reference->width, reference->height);

    double noise = 0.0;
    const enum status status =
        compare_noise(&noise, image->rgb, reference->rgb, image->width, image->height);
    if (status != STATUS_OK)
        return (enum lk_status)status;
    struct lk_image *made = NULL;
    if (difference != NULL) {
        const size_t value_count = (size_t)image->width * image->height * 3;
        made = calloc(1, sizeof(*made));
        if (made != NULL)
            made->rgb = malloc(value_count * sizeof(*made->rgb));
        if (made == NULL || made->rgb == NULL) {
            lk_image_free(made);
            return (enum lk_status)status_fail(STATUS_NO_MEMORY,
                                               "not enough memory for the difference image");
        }
        made->width = image->width;
        made->height = image->height;
        *difference = made;
    }
    compare_images(out, made != NULL ? made->rgb : NULL, image->rgb, reference->rgb, image->width,
                   image->height);
    out->noise = noise;
    return LK_OK;
}
