#include "cli/bench_cave.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"

#define RADIUS     10.0f
#define LIGHT_AREA 2.0 // m2, of all lights together
#define RADIANCE   60  // cd/m2
#define GLB_MAGIC  0x46546c67u
#define CHUNK_JSON 0x4e4f534au
#define CHUNK_BIN  0x004e4942u

// The file's parts, in their order: where each begins in the binary chunk.
struct layout {
    uint32_t columns, rows; // of the wall's grid of quadrilaterals
    uint32_t lights;
    size_t positions, normals, indices, light_positions, size;
};

static struct layout make_layout(uint32_t triangles, uint32_t lights)
{
    struct layout l = {.lights = lights};
    l.rows = (uint32_t)sqrt(triangles / 4.0);
    l.rows = l.rows > 2 ? l.rows : 2;
    l.columns = triangles / (2 * l.rows);
    const size_t vertices = (size_t)(l.rows + 1) * (l.columns + 1);
    l.normals = l.positions + 12 * vertices;
    l.indices = l.normals + 12 * vertices;
    l.light_positions = l.indices + (size_t)24 * l.rows * l.columns;
    l.size = l.light_positions + (size_t)36 * lights;
    return l;
}

// The wall at u, v in 0 .. 1: a sphere with waves of five lengths.
static void wall_point(float *out, double u, double v)
{
    const double pi = 3.14159265358979;
    const double theta = pi * v;
    const double phi = 2.0 * pi * u;
    const double x = sin(theta) * cos(phi);
    const double y = cos(theta);
    const double z = sin(theta) * sin(phi);
    double height = 0.0;
    double f = 3.0;
    for (int octave = 0; octave < 5; octave++, f *= 2.3)
        height += (sin(f * x + octave) + sin(f * y * 1.1 + 2.0) + sin(f * z * 0.9 + 4.0)) / f;
    const double r = (double)RADIUS * (1.0 + 0.18 * height);
    out[0] = (float)(r * x);
    out[1] = (float)(0.6 * r * y);
    out[2] = (float)(r * z);
}

static void cross_unit(float *out, const float *a, const float *b)
{
    const float c[3] = {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2],
                        a[0] * b[1] - a[1] * b[0]};
    const float length = sqrtf(c[0] * c[0] + c[1] * c[1] + c[2] * c[2]);
    for (int i = 0; i < 3; i++)
        out[i] = length > 0.0f ? c[i] / length : (i == 1 ? 1.0f : 0.0f);
}

static void fill_wall(char *data, const struct layout *l)
{
    float *positions = (float *)(data + l->positions);
    float *normals = (float *)(data + l->normals);
    uint32_t *indices = (uint32_t *)(data + l->indices);
#pragma omp parallel for
    for (uint32_t row = 0; row <= l->rows; row++) {
        for (uint32_t column = 0; column <= l->columns; column++) {
            const size_t i = (size_t)row * (l->columns + 1) + column;
            const double u = (double)column / l->columns;
            const double v = (double)row / l->rows;
            const double step = 1e-4;
            float near[4][3], du[3], dv[3];
            wall_point(positions + 3 * i, u, v);
            wall_point(near[0], u - step, v);
            wall_point(near[1], u + step, v);
            wall_point(near[2], u, fmax(v - step, 1e-6));
            wall_point(near[3], u, fmin(v + step, 1.0 - 1e-6));
            for (int k = 0; k < 3; k++) {
                du[k] = near[1][k] - near[0][k];
                dv[k] = near[3][k] - near[2][k];
            }
            cross_unit(normals + 3 * i, du, dv); // inwards
        }
    }
    for (uint32_t row = 0; row < l->rows; row++) {
        for (uint32_t column = 0; column < l->columns; column++) {
            const uint32_t a = row * (l->columns + 1) + column;
            const uint32_t b = a + l->columns + 1;
            const uint32_t quad[6] = {a, a + 1, b + 1, a, b + 1, b};
            memcpy(indices, quad, sizeof(quad));
            indices += 6;
        }
    }
}

// Triangles on a spiral from pole to pole, before the wall, facing the middle.
static void fill_lights(char *data, const struct layout *l)
{
    float *out = (float *)(data + l->light_positions);
    const double side = sqrt(LIGHT_AREA / l->lights * 4.0 / sqrt(3.0));
    for (uint32_t i = 0; i < l->lights; i++) {
        float p[3], inward[3], a[3], b[3];
        wall_point(p, fmod(i * 0.6180339887498949, 1.0),
                   acos(1.0 - 2.0 * (i + 0.5) / l->lights) / 3.14159265358979);
        const float length = sqrtf(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
        const float up[3] = {fabsf(p[1]) < 0.9f * length ? 0.0f : 1.0f,
                             fabsf(p[1]) < 0.9f * length ? 1.0f : 0.0f, 0.0f};
        for (int k = 0; k < 3; k++)
            inward[k] = -p[k] / length;
        cross_unit(a, up, inward);
        cross_unit(b, inward, a);
        for (int corner = 0; corner < 3; corner++) {
            const double angle = 2.0943951023931953 * corner;
            for (int k = 0; k < 3; k++)
                out[9 * (size_t)i + 3 * corner + k] =
                    0.95f * p[k] + (float)(side / sqrt(3.0)) *
                                       ((float)cos(angle) * a[k] + (float)sin(angle) * b[k]);
        }
    }
}

static int write_json(char *text, size_t size, const struct layout *l)
{
    const size_t vertices = (size_t)(l->rows + 1) * (l->columns + 1);
    const float most = 2.0f * RADIUS; // bounds need not be tight
    char bounds[128];
    snprintf(bounds, sizeof(bounds), "\"min\":[-%g,-%g,-%g],\"max\":[%g,%g,%g]", most, most, most,
             most, most, most);
    return snprintf(
        text, size,
        "{\"asset\":{\"version\":\"2.0\",\"generator\":\"lightkiln bench scale\"},"
        "\"extensionsUsed\":[\"KHR_materials_emissive_strength\"],"
        "\"scene\":0,\"scenes\":[{\"nodes\":[0,1]}],"
        "\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0,0.5,4]}],"
        "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"znear\":0.01}}],"
        "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.7,0.65,0.6,1],"
        "\"metallicFactor\":0}},{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0,0,0,1],"
        "\"metallicFactor\":0},\"emissiveFactor\":[1,0.9,0.7],\"extensions\":{"
        "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":%d}}}],"
        "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2,"
        "\"material\":0},{\"attributes\":{\"POSITION\":3},\"material\":1}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC3\",%"
        "s},"
        "{\"bufferView\":1,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC3\"},"
        "{\"bufferView\":2,\"componentType\":5125,\"count\":%zu,\"type\":\"SCALAR\"},"
        "{\"bufferView\":3,\"componentType\":5126,\"count\":%zu,\"type\":\"VEC3\",%s}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteOffset\":0,\"byteLength\":%zu},"
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu},"
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu},"
        "{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}],\"buffers\":[{\"byteLength\":%zu}]}",
        RADIANCE, vertices, bounds, vertices, (size_t)6 * l->rows * l->columns,
        (size_t)3 * l->lights, bounds, l->normals, l->normals, l->indices - l->normals, l->indices,
        l->light_positions - l->indices, l->light_positions, l->size - l->light_positions, l->size);
}

enum status bench_cave_write(const char *path, uint32_t triangles, uint32_t lights)
{
    const struct layout l = make_layout(triangles, lights);
    char json[4096];
    const int length = write_json(json, sizeof(json), &l);
    const uint32_t padded = ((uint32_t)length + 3u) & ~3u;
    const size_t size = 12 + 8 + padded + 8 + l.size;
    char *file = calloc(1, size);
    if (file == NULL || size > UINT32_MAX) {
        free(file);
        return status_fail(STATUS_NO_MEMORY, "%s: not enough memory for %u triangles", path,
                           triangles);
    }
    const uint32_t head[5] = {GLB_MAGIC, 2, (uint32_t)size, padded, CHUNK_JSON};
    const uint32_t chunk[2] = {(uint32_t)l.size, CHUNK_BIN};
    memcpy(file, head, sizeof(head));
    memset(file + 20, ' ', padded);
    memcpy(file + 20, json, (size_t)length);
    memcpy(file + 20 + padded, chunk, sizeof(chunk));
    fill_wall(file + 28 + padded, &l);
    fill_lights(file + 28 + padded, &l);
    const enum status status = file_write(path, file, size);
    free(file);
    return status;
}
