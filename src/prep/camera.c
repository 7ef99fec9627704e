#include "prep/camera.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/log.h"

#define DEFAULT_WIDTH   1024u
#define DEFAULT_ASPECT  (16.0 / 9.0)
#define FRAMING_YFOV    0.8 // radians, of the view of a scene without cameras
#define SIZE_MAX_PIXELS 16384.0

static enum status fail_to_find(const struct scene *scene, const char *selector)
{
    char list[512] = "";
    size_t used = 0;
    for (uint32_t i = 0; i < scene->camera_count && used < sizeof(list); i++) {
        const struct scene_camera *camera = &scene->cameras[i];
        const char *name = camera->name[0] != '\0' ? camera->name : camera->node_name;
        used += (size_t)snprintf(list + used, sizeof(list) - used, "%s%u \"%s\"", i > 0 ? ", " : "",
                                 i, name);
    }
    return status_fail(STATUS_USAGE, "%s has no camera \"%s\"; it has %s", scene->file, selector,
                       scene->camera_count > 0 ? list : "none");
}

// The camera that a selector names; NULL if there is none.
static const struct scene_camera *find_camera(const struct scene *scene, const char *selector)
{
    if (selector == NULL)
        return scene->camera_count > 0 ? &scene->cameras[0] : NULL;
    if (selector[0] == '\0')
        return NULL; // cameras without a name have an index
    for (uint32_t i = 0; i < scene->camera_count; i++)
        if (strcmp(scene->cameras[i].name, selector) == 0)
            return &scene->cameras[i];
    for (uint32_t i = 0; i < scene->camera_count; i++)
        if (strcmp(scene->cameras[i].node_name, selector) == 0)
            return &scene->cameras[i];
    char *end = NULL;
    const unsigned long index = strtoul(selector, &end, 10);
    if (selector[0] >= '0' && selector[0] <= '9' && *end == '\0' && index < scene->camera_count)
        return &scene->cameras[index];
    return NULL;
}

// A view of everything, from the front, the right and a little above.
static void frame_all(struct scene_camera *out, const struct geometry *geometry)
{
    double center[3];
    double radius2 = 0.0;
    for (int i = 0; i < 3; i++) {
        center[i] = 0.5 * ((double)geometry->lo[i] + geometry->hi[i]);
        const double half = 0.5 * ((double)geometry->hi[i] - geometry->lo[i]);
        radius2 += half * half;
    }
    const double radius = radius2 > 0.0 ? sqrt(radius2) : 1.0;
    const double distance = radius / sin(0.5 * FRAMING_YFOV);
    const double length = sqrt(0.5 * 0.5 + 0.35 * 0.35 + 1.0);
    const double back[3] = {0.5 / length, 0.35 / length, 1.0 / length}; // the camera's +Z
    const double flat = sqrt(back[0] * back[0] + back[2] * back[2]);
    const double right[3] = {back[2] / flat, 0.0, -back[0] / flat};
    const double up[3] = {back[1] * right[2] - back[2] * right[1],
                          back[2] * right[0] - back[0] * right[2],
                          back[0] * right[1] - back[1] * right[0]};
    *out = (struct scene_camera){.name = "", .node_name = "", .yfov_rad = FRAMING_YFOV};
    for (int i = 0; i < 3; i++) {
        out->to_world[4 * i + 0] = right[i];
        out->to_world[4 * i + 1] = up[i];
        out->to_world[4 * i + 2] = back[i];
        out->to_world[4 * i + 3] = center[i] + distance * back[i];
    }
}

// Fills in what is open of the image's size.
static enum status choose_size(uint32_t *width, uint32_t *height, double aspect)
{
    double w = *width;
    double h = *height;
    if (*width == 0 && *height == 0)
        w = DEFAULT_WIDTH;
    if (*height == 0)
        h = fmax(1.0, floor(w / aspect + 0.5));
    else if (*width == 0)
        w = fmax(1.0, floor(h * aspect + 0.5));
    if (w > SIZE_MAX_PIXELS || h > SIZE_MAX_PIXELS)
        return status_fail(STATUS_USAGE, "an image of %.0f x %.0f is larger than 16384 on a side",
                           w, h);
    *width = (uint32_t)w;
    *height = (uint32_t)h;
    return STATUS_OK;
}

static float4 row(const double *v)
{
    const float4 out = {(float)v[0], (float)v[1], (float)v[2], 0.0f};
    return out;
}

// Column `index` of the camera's frame, made unit.
static void frame_axis(double *out, const struct scene_camera *camera, int index)
{
    double length2 = 0.0;
    for (int i = 0; i < 3; i++) {
        out[i] = camera->to_world[4 * i + index];
        length2 += out[i] * out[i];
    }
    const double scale = length2 > 0.0 ? 1.0 / sqrt(length2) : 0.0;
    for (int i = 0; i < 3; i++)
        out[i] *= scale;
}

enum status camera_build(struct camera *out, const struct scene *scene,
                         const struct geometry *geometry, const char *selector, uint32_t width,
                         uint32_t height)
{
    struct scene_camera framing;
    const struct scene_camera *camera = find_camera(scene, selector);
    if (camera == NULL && (selector != NULL || scene->camera_count > 0))
        return fail_to_find(scene, selector);
    if (camera == NULL) {
        log_message(LOG_WARNING, "%s has no camera: looking at all of it from outside",
                    scene->file);
        frame_all(&framing, geometry);
        camera = &framing;
    }
    double aspect = camera->aspect > 0.0f ? camera->aspect : DEFAULT_ASPECT;
    if (camera->orthographic && camera->ymag > 0.0f)
        aspect = fabs((double)camera->xmag / camera->ymag);
    const enum status status = choose_size(&width, &height, aspect);
    if (status != STATUS_OK)
        return status;

    // Half the film's size at distance 1, or in metres.
    const double half_height =
        camera->orthographic ? fabs((double)camera->ymag) : tan(0.5 * camera->yfov_rad);
    const double half_width = half_height * width / height;
    double x[3], y[3], z[3], corner[3], right[3], down[3], forward[3], org[3];
    frame_axis(x, camera, 0);
    frame_axis(y, camera, 1);
    frame_axis(z, camera, 2);
    for (int i = 0; i < 3; i++) {
        org[i] = camera->to_world[4 * i + 3];
        forward[i] = -z[i];
        corner[i] =
            -half_width * x[i] + half_height * y[i] + (camera->orthographic ? 0.0 : forward[i]);
        right[i] = 2.0 * half_width / width * x[i];
        down[i] = -2.0 * half_height / height * y[i];
    }
    *out = (struct camera){
        .org = row(org),
        .corner = row(corner),
        .right = row(right),
        .down = row(down),
        .forward = row(forward),
        .width = width,
        .height = height,
        .orthographic = camera->orthographic,
    };
    return STATUS_OK;
}
