/**
 * @file
 * Small glTF files for the tests: written to a folder of their own, imported, compared.
 *
 * The test's data file "data.bin" holds, in this order:
 *
 *     0  float positions[4][3]   a unit square in z = 0, in strip order
 *    48  uint16_t list[6]        it as two triangles
 *    60  uint16_t strip[4]       it as a strip
 *    68  uint16_t fan[4]         it as a fan
 *    76  uint16_t odd[4]         0, 1, 65535, 9: restart and out of range
 *    84  uint8_t colors[4][4]    0, 51, 102, 255 in each
 *   100  float nan[3][3]         a triangle with a NaN
 *   136  uint8_t sparse_index[4] 3, and padding
 *   140  float sparse_value[3]   2, 2, 0
 *   152  end
 */
#ifndef TESTS_SCENE_GLTF_SUPPORT_H
#define TESTS_SCENE_GLTF_SUPPORT_H

#include <math.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "core/file.h"
#include "core/log.h"
#include "core/status.h"
#include "scene/gltf_import.h"

#define DATA_SIZE 152

static char gltf_folder[] = "/tmp/lightkiln-gltf-XXXXXX";
static char gltf_path[64];      // of the file written last
static char last_warning[1024]; // "" if there was none
static unsigned warning_total;

// Buffer views and accessors of data.bin, as named above; 0 positions, 1 list, 2 strip, 3 fan,
// 4 odd, 5 colors, 6 nan, 7 sparse positions. To be followed by more members and a '}'.
static const char DATA_JSON[] =
    "{\"asset\":{\"version\":\"2.0\"},"
    "\"buffers\":[{\"uri\":\"data.bin\",\"byteLength\":152}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},"
    "{\"buffer\":0,\"byteOffset\":48,\"byteLength\":36},"
    "{\"buffer\":0,\"byteOffset\":84,\"byteLength\":16},"
    "{\"buffer\":0,\"byteOffset\":100,\"byteLength\":36},"
    "{\"buffer\":0,\"byteOffset\":136,\"byteLength\":4},"
    "{\"buffer\":0,\"byteOffset\":140,\"byteLength\":12}],"
    "\"accessors\":["
    "{\"bufferView\":0,\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},"
    "{\"bufferView\":1,\"componentType\":5123,\"count\":6,\"type\":\"SCALAR\"},"
    "{\"bufferView\":1,\"byteOffset\":12,\"componentType\":5123,\"count\":4,\"type\":\"SCALAR\"},"
    "{\"bufferView\":1,\"byteOffset\":20,\"componentType\":5123,\"count\":4,\"type\":\"SCALAR\"},"
    "{\"bufferView\":1,\"byteOffset\":28,\"componentType\":5123,\"count\":3,\"type\":\"SCALAR\"},"
    "{\"bufferView\":2,\"componentType\":5121,\"normalized\":true,\"count\":4,\"type\":\"VEC4\"},"
    "{\"bufferView\":3,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},"
    "{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":1,"
    "\"indices\":{\"bufferView\":4,\"componentType\":5121},\"values\":{\"bufferView\":5}}}]";

// One node with one mesh, "door", with one primitive; to be followed by a '}'.
#define ONE_MESH(primitive)                                                                        \
    ",\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"mesh\":0}],"                                      \
    "\"meshes\":[{\"name\":\"door\",\"primitives\":[{" primitive "}]}]"

static inline void fill_data(uint8_t data[DATA_SIZE])
{
    static const float positions[12] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0};
    static const uint16_t indices[18] = {0, 1, 2, 1, 3, 2, 0, 1, 2, 3, 0, 1, 3, 2, 0, 1, 65535, 9};
    const float nan_triangle[9] = {0, 0, 0, 1, NAN, 0, 0, 1, 0};
    static const float sparse_value[3] = {2, 2, 0};
    memset(data, 0, DATA_SIZE);
    memcpy(data, positions, sizeof(positions));
    memcpy(data + 48, indices, sizeof(indices));
    for (int i = 0; i < 16; i++)
        data[84 + i] = (uint8_t[]){0, 51, 102, 255}[i % 4];
    memcpy(data + 100, nan_triangle, sizeof(nan_triangle));
    data[136] = 3;
    memcpy(data + 140, sparse_value, sizeof(sparse_value));
}

static inline void keep_warning(void *user, enum log_level level, const char *message)
{
    (void)user;
    if (level == LOG_WARNING) {
        snprintf(last_warning, sizeof(last_warning), "%s", message);
        warning_total++;
    }
}

static inline void write_bytes(const char *name, const void *bytes, size_t size)
{
    char path[128];
    snprintf(path, sizeof(path), "%s/%s", gltf_folder, name);
    if (file_write(path, bytes, size) != STATUS_OK)
        abort();
}

static inline int make_gltf_folder(void **state)
{
    (void)state;
    log_set_function(keep_warning, NULL);
    if (mkdtemp(gltf_folder) == NULL)
        return -1;
    uint8_t data[DATA_SIZE];
    fill_data(data);
    write_bytes("data.bin", data, sizeof(data));
    return 0;
}

static inline int remove_gltf_folder(void **state)
{
    (void)state;
    char command[64];
    snprintf(command, sizeof(command), "rm -r '%s'", gltf_folder);
    return system(command);
}

// Writes a file of this content and imports it.
static inline enum status import_text(struct scene *scene, const char *text)
{
    last_warning[0] = '\0';
    warning_total = 0;
    *scene = (struct scene){0};
    snprintf(gltf_path, sizeof(gltf_path), "%s/test.gltf", gltf_folder);
    write_bytes("test.gltf", text, strlen(text));
    return gltf_import(scene, gltf_path);
}

// Imports DATA_JSON with more members, given as to printf.
__attribute__((format(printf, 2, 3))) static inline enum status import_members(struct scene *scene,
                                                                               const char *format,
                                                                               ...)
{
    char text[8192];
    size_t used = (size_t)snprintf(text, sizeof(text), "%s", DATA_JSON);
    va_list args;
    va_start(args, format);
    used += (size_t)vsnprintf(text + used, sizeof(text) - used, format, args);
    va_end(args);
    if (used + 2 > sizeof(text))
        abort();
    strcat(text, "}");
    return import_text(scene, text);
}

#endif
