#include "prep/emission.h"

#include <math.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/color.h"
#include "shared/material.h"

#define GRID_MIN  2    // cells along a side of the triangle
#define GRID_MAX  12   // cells: 144 points take 10 us
#define CELLS_MAX 3    // of a pyramid level looked at along an axis
#define LEVEL_MAX 17   // levels of an image of 65535 texels
#define MISSED    1024 // part of the brightest texel that is the least mean of what is not dark

// Maxima of an image's bytes over squares of 2^level texels.
struct pyramid {
    uint8_t *levels[LEVEL_MAX]; // RGBA; level 0 is the image's own; owned but for that
    uint32_t width[LEVEL_MAX], height[LEVEL_MAX];
    int level_count;
};

// What one textured emissive material looks like from a triangle.
struct source {
    const struct scene_texture *texture;
    const struct scene_texture_use *use;
    const struct scene_image *image;
    const struct pyramid *pyramid;
    const double *linear; // [256] of sRGB bytes
    double weights[3];    // luminance of a texel: the sum of weight times linear value
};

static double texel_luminance(const struct source *source, const uint8_t *rgba)
{
    double sum = 0.0;
    for (int k = 0; k < 3; k++)
        sum += source->weights[k] * source->linear[rgba[k]];
    return sum;
}

// ---- Texture coordinates

// The two texels of one axis and where between them u lies, as lib/texture.h finds them.
static double wrap_axis(int64_t *near, int64_t *far, double u, int64_t size, uint32_t wrap,
                        bool nearest)
{
    if (wrap == TEXTURE_WRAP_CLAMP) {
        u = fmin(fmax(u, 0.0), 1.0);
    } else if (wrap == TEXTURE_WRAP_MIRROR) {
        u -= 2.0 * floor(0.5 * u);
        u = u > 1.0 ? 2.0 - u : u;
    } else {
        u -= floor(u);
    }
    const double x = u * (double)size - (nearest ? 0.0 : 0.5);
    *near = (int64_t)floor(x);
    *far = *near + 1;
    const double blend = nearest ? 0.0 : x - floor(x);
    if (wrap == TEXTURE_WRAP_REPEAT) {
        *near = *near < 0 ? size - 1 : *near;
        *far = *far >= size ? *far - size : *far;
    }
    *near = *near < 0 ? 0 : *near < size ? *near : size - 1;
    *far = *far < 0 ? 0 : *far < size ? *far : size - 1;
    return blend;
}

static double sample(const struct source *source, const double *uv)
{
    const struct scene_image *image = source->image;
    const bool nearest = source->texture->nearest;
    int64_t x[2], y[2];
    const double bx =
        wrap_axis(&x[0], &x[1], uv[0], image->width, source->texture->wrap_s, nearest);
    const double by =
        wrap_axis(&y[0], &y[1], uv[1], image->height, source->texture->wrap_t, nearest);
    double sum = 0.0;
    for (int i = 0; i < 4; i++) {
        const double weight = (i & 1 ? bx : 1.0 - bx) * (i & 2 ? by : 1.0 - by);
        const uint8_t *texel = image->rgba + 4 * (y[i >> 1] * image->width + x[i & 1]);
        sum += weight > 0.0 ? weight * texel_luminance(source, texel) : 0.0;
    }
    return sum;
}

static void load_uv(double uv[3][2], const struct source *source, const struct geometry *geometry,
                    uint32_t index)
{
    const struct triangle *triangle = &geometry->triangles[index];
    const uint32_t corners[3] = {triangle->v0, triangle->v1, triangle->v2};
    const float *m = source->use->uv_matrix;
    for (int i = 0; i < 3; i++) {
        const float4 both = geometry->vertices[corners[i]].uv;
        const bool second = source->use->texcoord == 1;
        const double u = second ? both.z : both.x;
        const double v = second ? both.w : both.y;
        uv[i][0] = m[0] * u + m[1] * v + source->use->uv_offset[0];
        uv[i][1] = m[2] * u + m[3] * v + source->use->uv_offset[1];
    }
}

// Mean over the middles of the n^2 small triangles that a triangle divides into, as many as it
// covers texels, within bounds.
static double mean_over_grid(const struct source *source, double uv[3][2])
{
    const double ux = uv[1][0] - uv[0][0];
    const double uy = uv[1][1] - uv[0][1];
    const double vx = uv[2][0] - uv[0][0];
    const double vy = uv[2][1] - uv[0][1];
    const double texels =
        0.5 * fabs(ux * vy - uy * vx) * source->image->width * source->image->height;
    const int n = (int)fmin(fmax(ceil(sqrt(texels)), GRID_MIN), GRID_MAX);
    double sum = 0.0;
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < 2 * (n - i) - 1; j++) {
            const bool upside_down = j & 1;
            const double third = upside_down ? 2.0 / 3.0 : 1.0 / 3.0;
            const double s = (i + third) / n;
            const double t = (j / 2 + third) / n;
            const double at[2] = {uv[0][0] + s * ux + t * vx, uv[0][1] + s * uy + t * vy};
            sum += sample(source, at);
        }
    }
    return sum / ((double)n * n);
}

// ---- The brightest texel

static void pyramid_free(struct pyramid *pyramid)
{
    for (int i = 1; i < pyramid->level_count; i++)
        free(pyramid->levels[i]);
    *pyramid = (struct pyramid){0};
}

static void halve(uint8_t *out, uint32_t width, uint32_t height, const uint8_t *in,
                  uint32_t in_width, uint32_t in_height)
{
    for (uint32_t y = 0; y < height; y++) {
        for (uint32_t x = 0; x < width; x++) {
            uint8_t *most = out + 4 * ((size_t)y * width + x);
            memset(most, 0, 4);
            for (uint32_t i = 0; i < 4; i++) {
                const uint32_t at_x = 2 * x + (i & 1) < in_width ? 2 * x + (i & 1) : 2 * x;
                const uint32_t at_y = 2 * y + (i >> 1) < in_height ? 2 * y + (i >> 1) : 2 * y;
                const uint8_t *texel = in + 4 * ((size_t)at_y * in_width + at_x);
                for (int k = 0; k < 3; k++)
                    most[k] = texel[k] > most[k] ? texel[k] : most[k];
            }
        }
    }
}

static bool pyramid_build(struct pyramid *out, const struct scene_image *image)
{
    *out = (struct pyramid){.levels = {image->rgba},
                            .width = {image->width},
                            .height = {image->height},
                            .level_count = 1};
    for (int i = 1; out->width[i - 1] > 1 || out->height[i - 1] > 1; i++) {
        out->width[i] = (out->width[i - 1] + 1) / 2;
        out->height[i] = (out->height[i - 1] + 1) / 2;
        out->levels[i] = array_alloc((size_t)out->width[i] * out->height[i], 4);
        if (out->levels[i] == NULL) {
            pyramid_free(out);
            return false;
        }
        out->level_count = i + 1;
        halve(out->levels[i], out->width[i], out->height[i], out->levels[i - 1], out->width[i - 1],
              out->height[i - 1]);
    }
    return true;
}

// The texels of one axis that coordinates from lo to hi may touch: *first .. *first + count - 1,
// to be taken modulo `size`. A texel more on each side stands for the filter, and some for the
// rounding of large coordinates.
static int64_t touched(int64_t *first, double lo, double hi, int64_t size, uint32_t wrap)
{
    const double margin = 1.5 + fmax(fabs(lo), fabs(hi)) * (double)size * 0x1p-20;
    double from = floor(lo * (double)size - margin);
    double to = floor(hi * (double)size + margin);
    *first = 0;
    if (wrap == TEXTURE_WRAP_CLAMP) {
        from = fmin(fmax(from, 0.0), (double)size - 1.0);
        to = fmin(fmax(to, 0.0), (double)size - 1.0);
    } else if (!(to - from + 1.0 < (double)size)) {
        return size;
    } else if (wrap == TEXTURE_WRAP_MIRROR) {
        // Within one copy, turned or not; else all of it.
        const double copy = floor(from / (double)size);
        if (copy != floor(to / (double)size))
            return size;
        const bool turned = fmod(fabs(copy), 2.0) == 1.0;
        const double begin =
            turned ? (copy + 1.0) * (double)size - 1.0 - to : from - copy * (double)size;
        to = begin + (to - from);
        from = begin;
    } else {
        const double shift = floor(from / (double)size) * (double)size;
        from -= shift;
        to -= shift;
    }
    *first = (int64_t)from;
    return (int64_t)(to - from) + 1;
}

// The square of a level that holds a texel, and how many texels it goes on for.
static int64_t square_at(int64_t *left, int64_t texel, int level, int64_t size)
{
    const int64_t at = texel % size;
    const int64_t end = ((at >> level) + 1) << level;
    *left = (end < size ? end : size) - at;
    return at >> level;
}

// The largest luminance of any texel that a triangle may touch.
static double find_brightest(const struct source *source, double uv[3][2])
{
    const struct pyramid *pyramid = source->pyramid;
    const int64_t size[2] = {source->image->width, source->image->height};
    const uint32_t wraps[2] = {source->texture->wrap_s, source->texture->wrap_t};
    int64_t first[2], count[2];
    for (int k = 0; k < 2; k++) {
        const double lo = fmin(fmin(uv[0][k], uv[1][k]), uv[2][k]);
        const double hi = fmax(fmax(uv[0][k], uv[1][k]), uv[2][k]);
        count[k] = touched(&first[k], lo, hi, size[k], wraps[k]);
    }

    // Look at few squares, on the level where they are large enough.
    int level = 0;
    while (level + 1 < pyramid->level_count &&
           ((count[0] >> level) > CELLS_MAX || (count[1] >> level) > CELLS_MAX))
        level++;
    uint8_t most[4] = {0};
    for (int64_t y = 0, high = 0; y < count[1]; y += high) {
        const int64_t row = square_at(&high, first[1] + y, level, size[1]);
        for (int64_t x = 0, wide = 0; x < count[0]; x += wide) {
            const int64_t column = square_at(&wide, first[0] + x, level, size[0]);
            const uint8_t *texel =
                pyramid->levels[level] + 4 * (row * pyramid->width[level] + column);
            for (int k = 0; k < 3; k++)
                most[k] = texel[k] > most[k] ? texel[k] : most[k];
        }
    }
    return texel_luminance(source, most);
}

// ---- The whole scene

// Finds what the triangles of the textured materials emit.
static void find_triangles(struct emission *out, const struct scene *scene,
                           const struct geometry *geometry, const struct pyramid *pyramids)
{
    const int64_t count = geometry->triangle_count;
    double linear[256];
    for (int i = 0; i < 256; i++)
        linear[i] = color_from_srgb(i / 255.0);
#pragma omp parallel for schedule(dynamic, 1024)
    for (int64_t i = 0; i < count; i++) {
        const uint32_t index = geometry->triangles[i].material;
        const struct scene_material *material = &scene->materials[index];
        out->triangles[i] = (float)out->materials[index];
        if (!(out->materials[index] > 0.0) || material->emissive_texture.texture == SCENE_NONE)
            continue;
        const struct scene_texture *texture = &scene->textures[material->emissive_texture.texture];
        const float *e = material->emission;
        const struct source source = {
            .texture = texture,
            .use = &material->emissive_texture,
            .image = &scene->images[texture->image],
            .pyramid = &pyramids[texture->image],
            .linear = linear,
            .weights = {color_luminance(e[0], 0, 0), color_luminance(0, e[1], 0),
                        color_luminance(0, 0, e[2])},
        };
        double uv[3][2];
        load_uv(uv, &source, geometry, (uint32_t)i);
        const double brightest = find_brightest(&source, uv);
        const double mean = brightest > 0.0 ? mean_over_grid(&source, uv) : 0.0;
        out->triangles[i] = (float)fmax(mean, brightest / MISSED);
    }
}

// The image of a material's emission, or SCENE_NONE.
static int32_t image_of(const struct emission *emission, const struct scene *scene, uint32_t index)
{
    const int32_t texture = scene->materials[index].emissive_texture.texture;
    return emission->materials[index] > 0.0 && texture != SCENE_NONE
               ? scene->textures[texture].image
               : SCENE_NONE;
}

enum status emission_build(struct emission *out, const struct scene *scene,
                           const struct geometry *geometry)
{
    enum status status = STATUS_OK;
    struct emission emission = {0};
    struct pyramid *pyramids = calloc((size_t)scene->image_count + 1, sizeof(*pyramids));
    bool ok = pyramids != NULL;
    bool textured = false;

    emission.materials = array_alloc(scene->material_count, sizeof(*emission.materials));
    ok = ok && emission.materials != NULL;
    for (uint32_t i = 0; i < scene->material_count && ok; i++) {
        const struct scene_material *material = &scene->materials[i];
        const float *e = material->emission;
        emission.materials[i] = material->unlit ? 0.0 : color_luminance(e[0], e[1], e[2]);
        const int32_t image = image_of(&emission, scene, i);
        if (image == SCENE_NONE)
            continue;
        textured = true;
        if (pyramids[image].level_count == 0)
            ok = pyramid_build(&pyramids[image], &scene->images[image]);
    }
    if (ok && textured) {
        emission.triangles = array_alloc(geometry->triangle_count, sizeof(*emission.triangles));
        ok = emission.triangles != NULL;
    }
    if (!ok) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for the emission of %u triangles",
                             geometry->triangle_count);
        goto cleanup;
    }
    if (textured)
        find_triangles(&emission, scene, geometry, pyramids);
    *out = emission;
    emission = (struct emission){0}; // the caller owns it now

cleanup:
    emission_free(&emission);
    for (uint32_t i = 0; pyramids != NULL && i < scene->image_count; i++)
        pyramid_free(&pyramids[i]);
    free(pyramids);
    return status;
}

double emission_of(const struct emission *emission, const struct geometry *geometry,
                   uint32_t triangle)
{
    return emission->triangles != NULL
               ? (double)emission->triangles[triangle]
               : emission->materials[geometry->triangles[triangle].material];
}

void emission_free(struct emission *emission)
{
    free(emission->triangles);
    free(emission->materials);
    *emission = (struct emission){0};
}
