#include "output/image_file.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "core/json.h"
#include "output/report.h"
#include "scene/image_io.h"

static const struct {
    const char *extension;
    enum image_kind kind;
} formats[] = {
    {".exr", IMAGE_LINEAR},   {".hdr", IMAGE_LINEAR},  {".tif", IMAGE_LINEAR},
    {".tiff", IMAGE_LINEAR},  {".png", IMAGE_DISPLAY}, {".jpg", IMAGE_DISPLAY},
    {".jpeg", IMAGE_DISPLAY},
};

enum status image_file_kind(enum image_kind *out, const char *path)
{
    const char *slash = strrchr(path, '/');
    const char *dot = strrchr(slash != NULL ? slash : path, '.');
    for (size_t i = 0; dot != NULL && i < sizeof(formats) / sizeof(formats[0]); i++) {
        if (strcasecmp(dot, formats[i].extension) == 0) {
            *out = formats[i].kind;
            return STATUS_OK;
        }
    }
    return status_fail(STATUS_USAGE,
                       "%s: no image format has this extension; use .exr, .hdr, .tif, .png or .jpg",
                       path);
}

#define ATTRIBUTES_MAX 6

// Texts of a header; the attributes point into it.
struct header {
    struct image_attribute attributes[ATTRIBUTES_MAX];
    size_t count;
    char software[128], seed[16], spp[32], device[4096];
    struct json settings;
};

static void add(struct header *header, const char *name, const char *value)
{
    header->attributes[header->count++] = (struct image_attribute){name, value};
}

static enum status fill_header(struct header *header, const struct lk_render_info *info,
                               const char *version)
{
    snprintf(header->software, sizeof(header->software), "lightkiln %s", version);
    add(header, "Software", header->software);
    if (info == NULL)
        return STATUS_OK;

    header->settings.compact = true;
    report_picture_settings(&header->settings, NULL, &info->settings);
    const enum status status = json_finish(&header->settings);
    if (status != STATUS_OK)
        return status;

    snprintf(header->seed, sizeof(header->seed), "%u", info->settings.seed);
    snprintf(header->spp, sizeof(header->spp), "%.9g", info->spp);
    for (uint32_t i = 0; i < info->device_count; i++) {
        const struct lk_device_info *device = &info->devices[i].info;
        const size_t used = strlen(header->device);
        snprintf(header->device + used, sizeof(header->device) - used, "%s%s, %s, driver %s",
                 i > 0 ? "; " : "", device->platform, device->name, device->driver);
    }
    add(header, "lightkiln:seed", header->seed);
    add(header, "lightkiln:settings", header->settings.text);
    add(header, "lightkiln:device", header->device);
    add(header, "lightkiln:samples_per_pixel", header->spp);
    add(header, "lightkiln:units", info->settings.quantity == LK_IRRADIANCE ? "lux" : "cd/m2");
    return STATUS_OK;
}

enum status image_file_write(const char *path, const float *rgb, uint32_t width, uint32_t height,
                             const struct lk_render_info *info, const char *version,
                             float exposure_ev, enum tonemap tonemap)
{
    struct header header = {0};
    float *display = NULL;

    enum image_kind kind = IMAGE_LINEAR;
    enum status status = image_file_kind(&kind, path);
    if (status != STATUS_OK)
        return status;
    status = fill_header(&header, info, version);
    if (status != STATUS_OK)
        goto cleanup;

    if (kind == IMAGE_DISPLAY) {
        const size_t pixel_count = (size_t)width * height;
        display = malloc(pixel_count * 3 * sizeof(*display));
        if (display == NULL) {
            status = status_fail(STATUS_NO_MEMORY, "%s: not enough memory", path);
            goto cleanup;
        }
        tonemap_apply(display, rgb, pixel_count, exposure_ev, tonemap);
    }
    status = image_write_rgb(path, display != NULL ? display : rgb, width, height,
                             header.attributes, header.count);

cleanup:
    free(display);
    json_free(&header.settings);
    return status;
}
