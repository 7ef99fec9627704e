#include "prep/environment.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#include "prep/array.h"
#include "prep/color.h"
#include "prep/sky.h"
#include "scene/image_io.h"
#include "scene/scene.h"

// ---- The map

static enum status allocate(struct environment *out, uint32_t width, uint32_t height)
{
    out->map.width = width;
    out->map.height = height;
    out->texels = array_alloc((size_t)width * height, sizeof(*out->texels));
    return out->texels != NULL
               ? STATUS_OK
               : status_fail(STATUS_NO_MEMORY, "no memory for an environment of %u x %u texels",
                             width, height);
}

// Takes the texels of a lat-long image, rgb [width * height * 3].
static enum status take_image(struct environment *out, const struct environment_request *request,
                              const char *name, const float *rgb, uint32_t width, uint32_t height)
{
    enum status status = allocate(out, width, height);
    for (size_t i = 0; i < (size_t)width * height && status == STATUS_OK; i++) {
        const float *from = rgb + 3 * i;
        float to[3];
        for (int k = 0; k < 3; k++) {
            if (!isfinite(from[k]))
                status = status_fail(STATUS_FORMAT, "%s: texel %zu, %zu is not a finite number",
                                     name, i % width, i / width);
            to[k] = fminf(fmaxf(from[k], 0.0f) * request->strength, FLT_MAX);
        }
        out->texels[i] = (float4){to[0], to[1], to[2], 0.0f};
    }
    const double turns = request->rotation_deg / 360.0;
    out->map.turn = (float)(turns - floor(turns));
    return status;
}

static enum status load_image(struct environment *out, const struct environment_request *request)
{
    float *rgb = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    enum status status = image_read_rgb(&rgb, &width, &height, request->path);
    if (status == STATUS_OK)
        status = take_image(out, request, request->path, rgb, width, height);
    free(rgb);
    return status;
}

static enum status make_sky(struct environment *out, const struct environment_request *request)
{
    const struct sky sky = {
        .azimuth_deg = request->sky_azimuth_deg,
        .elevation_deg = request->sky_elevation_deg,
        .turbidity = request->sky_turbidity,
        .strength = request->strength,
    };
    const enum status status = allocate(out, SKY_WIDTH, SKY_HEIGHT);
    if (status == STATUS_OK)
        sky_bake(out->texels, &out->sun, &sky);
    out->has_sun = true;
    return status;
}

static enum status make_background(struct environment *out,
                                   const struct environment_request *request)
{
    const float *color = request->background;
    const enum status status = allocate(out, 1, 1);
    if (status == STATUS_OK)
        out->texels[0] = (float4){color[0], color[1], color[2], 0.0f};
    return status;
}

// ---- Drawing from it

static double luminance_at(const struct environment *e, uint32_t x, uint32_t y)
{
    const float4 texel = e->texels[(size_t)y * e->map.width + x];
    return color_luminance(texel.x, texel.y, texel.z);
}

// The mean luminance over a texel of the map as it is filtered: an eighth of each neighbour either
// way. Columns go round, rows end at the poles.
static double filtered_luminance(const struct environment *e, uint32_t x, uint32_t y)
{
    static const double weights[3] = {0.125, 0.75, 0.125};
    const uint32_t columns[3] = {x > 0 ? x - 1 : e->map.width - 1, x,
                                 x + 1 < e->map.width ? x + 1 : 0};
    const uint32_t rows[3] = {y > 0 ? y - 1 : 0, y, y + 1 < e->map.height ? y + 1 : y};
    double sum = 0.0;
    for (int j = 0; j < 3; j++)
        for (int i = 0; i < 3; i++)
            sum += weights[i] * weights[j] * luminance_at(e, columns[i], rows[j]);
    return sum;
}

// Solid angle of a texel of a row, sr.
static double texel_angle(const struct environment *e, uint32_t y)
{
    const double step = M_PI / e->map.height;
    return 2.0 * M_PI / e->map.width * (cos(y * step) - cos((y + 1) * step));
}

// Fills the alias table from weights [count] of mean 1, which are used up. Columns of less than the
// mean are topped up by one of more (Vose 1991).
static void fill_alias(struct environment_alias *alias, double *weights, uint32_t *stack,
                       uint32_t count)
{
    uint32_t small_count = 0; // from the front of the stack; the large ones from its end
    uint32_t large_first = count;
    uint32_t brightest = 0;
    for (uint32_t i = 0; i < count; i++) {
        brightest = weights[i] > weights[brightest] ? i : brightest;
        if (weights[i] < 1.0)
            stack[small_count++] = i;
        else
            stack[--large_first] = i;
    }
    while (small_count > 0 && large_first < count) {
        const uint32_t small = stack[--small_count];
        const uint32_t large = stack[large_first];
        alias[small] = (struct environment_alias){(float)weights[small], large};
        weights[large] -= 1.0 - weights[small];
        if (weights[large] < 1.0) {
            large_first++;
            stack[small_count++] = large;
        }
    }

    // What is left is 1 but for rounding, unless it was nothing from the start.
    while (large_first < count) {
        const uint32_t i = stack[large_first++];
        alias[i] = (struct environment_alias){1.0f, i};
    }
    while (small_count > 0) {
        const uint32_t i = stack[--small_count];
        alias[i] = (struct environment_alias){weights[i] > 0.5 ? 1.0f : 0.0f, brightest};
    }
}

// Makes the alias table, and writes each texel's density. An environment without light is emptied.
static enum status build_distribution(struct environment *e)
{
    enum status status = STATUS_OK;
    const uint32_t width = e->map.width;
    const uint32_t height = e->map.height;
    const size_t count = (size_t)width * height;
    double *weights = array_alloc(count, sizeof(*weights));
    uint32_t *stack = array_alloc(count, sizeof(*stack));
    e->alias = array_alloc(count, sizeof(*e->alias));
    if (weights == NULL || stack == NULL || e->alias == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for an environment of %u x %u texels",
                             width, height);
        goto cleanup;
    }

    double sum = 0.0;
    for (uint32_t y = 0; y < height; y++) {
        const double angle = texel_angle(e, y);
        for (uint32_t x = 0; x < width; x++) {
            const double weight = filtered_luminance(e, x, y) * angle;
            weights[(size_t)y * width + x] = weight;
            sum += weight;
        }
    }
    if (!(sum > 0.0)) {
        environment_free(e);
        goto cleanup;
    }
    for (uint32_t y = 0; y < height; y++) {
        const double angle = texel_angle(e, y);
        for (uint32_t x = 0; x < width; x++) {
            const size_t i = (size_t)y * width + x;
            e->texels[i].w = (float)(weights[i] / sum / angle);
            weights[i] *= (double)count / sum;
        }
    }
    fill_alias(e->alias, weights, stack, (uint32_t)count);

cleanup:
    free(stack);
    free(weights);
    return status;
}

enum status environment_build(struct environment *out, const struct environment_request *request)
{
    struct environment e = {0};
    const float *background = request->background;
    enum status status = STATUS_OK;
    if (request->path != NULL)
        status = load_image(&e, request);
    else if (request->sky_elevation_deg > 0.0f)
        status = make_sky(&e, request);
    else if (background[0] > 0.0f || background[1] > 0.0f || background[2] > 0.0f)
        status = make_background(&e, request);
    else if (request->own != NULL && request->own->width > 0)
        status = take_image(&e, request, "the scene's environment", request->own->rgb,
                            request->own->width, request->own->height);
    if (status == STATUS_OK && e.texels != NULL)
        status = build_distribution(&e);
    if (status != STATUS_OK) {
        environment_free(&e);
        return status;
    }
    *out = e;
    return STATUS_OK;
}

uint64_t environment_size(const struct environment *environment)
{
    return (uint64_t)environment->map.width * environment->map.height *
               (sizeof(*environment->texels) + sizeof(*environment->alias)) +
           (environment->has_sun ? sizeof(environment->sun) : 0);
}

void environment_free(struct environment *environment)
{
    free(environment->alias);
    free(environment->texels);
    *environment = (struct environment){0};
}
