#include "gltf_writer.h"

#include <stdarg.h>
#include <setjmp.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "png.h"

// ---- Sections

static FILE *open_section(struct gltf_section *section)
{
    if (section->file == NULL)
        section->file = open_memstream(&section->text, &section->size);
    assert_non_null(section->file);
    return section->file;
}

// Goes on to the next element; returns where to write it.
static FILE *next_element(struct gltf_section *section)
{
    FILE *file = open_section(section);
    fputs(section->count++ > 0 ? ",\n" : "", file);
    return file;
}

static int add_text(struct gltf_section *section, const char *format, va_list list)
{
    vfprintf(next_element(section), format, list);
    return section->count - 1;
}

// Makes the text complete and readable.
static const char *finish_section(struct gltf_section *section)
{
    fflush(open_section(section));
    return section->text;
}

static void free_section(struct gltf_section *section)
{
    if (section->file != NULL)
        fclose(section->file);
    free(section->text);
    *section = (struct gltf_section){0};
}

// ---- Materials and textures

int gltf_material(struct gltf_writer *writer, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    const int index = add_text(&writer->materials, format, list);
    va_end(list);
    return index;
}

int gltf_lambert(struct gltf_writer *writer, double albedo)
{
    return gltf_emitter(writer, albedo, 0.0, false);
}

int gltf_emitter(struct gltf_writer *writer, double albedo, double radiance, bool double_sided)
{
    return gltf_material(writer,
                         "{\"pbrMetallicRoughness\":{\"baseColorFactor\":[%.9g,%.9g,%.9g,1],"
                         "\"metallicFactor\":0},\"emissiveFactor\":[%d,%d,%d],\"doubleSided\":%s,"
                         "\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0},"
                         "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":%.9g}}}",
                         albedo, albedo, albedo, radiance > 0.0, radiance > 0.0, radiance > 0.0,
                         double_sided ? "true" : "false", radiance);
}

// Writes bytes as base64 (RFC 4648).
static void write_base64(FILE *file, const uint8_t *bytes, size_t size)
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for (size_t i = 0; i < size; i += 3) {
        uint32_t bits = (uint32_t)bytes[i] << 16;
        bits |= i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0;
        bits |= i + 2 < size ? bytes[i + 2] : 0;
        fputc(digits[bits >> 18], file);
        fputc(digits[bits >> 12 & 63], file);
        fputc(i + 1 < size ? digits[bits >> 6 & 63] : '=', file);
        fputc(i + 2 < size ? digits[bits & 63] : '=', file);
    }
}

static int add_image(struct gltf_writer *writer, const uint8_t *rgba, uint32_t width,
                     uint32_t height)
{
    size_t size = 0;
    uint8_t *bytes = png_encode(&size, rgba, width, height);
    assert_non_null(bytes);
    FILE *file = next_element(&writer->images);
    fputs("{\"uri\":\"data:image/png;base64,", file);
    write_base64(file, bytes, size);
    fputs("\"}", file);
    free(bytes);
    return writer->images.count - 1;
}

int gltf_texture(struct gltf_writer *writer, const uint8_t *rgba, uint32_t width, uint32_t height)
{
    const int image = add_image(writer, rgba, width, height);
    fprintf(next_element(&writer->textures), "{\"source\":%d,\"sampler\":0}", image);
    return writer->textures.count - 1;
}

// ---- Surfaces

// Adds an accessor over `count` elements of four-byte components; returns its index.
static int add_accessor(struct gltf_writer *writer, const void *data, uint32_t count,
                        uint32_t components, bool is_float)
{
    static const char *const types[] = {"", "SCALAR", "VEC2", "VEC3"};
    FILE *bytes = open_section(&writer->bytes);
    const long offset = ftell(bytes);
    const size_t size = (size_t)count * components * 4;
    fwrite(data, 1, size, bytes);
    fprintf(next_element(&writer->views), "{\"buffer\":0,\"byteOffset\":%ld,\"byteLength\":%zu}",
            offset, size);
    fprintf(next_element(&writer->accessors),
            "{\"bufferView\":%d,\"componentType\":%d,\"count\":%u,\"type\":\"%s\"}",
            writer->views.count - 1, is_float ? 5126 : 5125, count, types[components]);
    return writer->accessors.count - 1;
}

static void add_attribute(struct gltf_writer *writer, const char *name, const float *data,
                          uint32_t count, uint32_t components)
{
    if (data == NULL)
        return;
    const int accessor = add_accessor(writer, data, count, components, true);
    fprintf(writer->meshes.file, ",\"%s\":%d", name, accessor);
}

int gltf_mesh(struct gltf_writer *writer, int material, const struct gltf_mesh *mesh)
{
    const uint32_t count = mesh->vertex_count;
    const int triangles = add_accessor(writer, mesh->triangles, 3 * mesh->triangle_count, 1, false);
    const int positions = add_accessor(writer, mesh->positions, count, 3, true);
    FILE *file = next_element(&writer->meshes);
    fprintf(file,
            "{\"primitives\":[{\"material\":%d,\"indices\":%d,\"attributes\":{\"POSITION\":%d",
            material, triangles, positions);
    add_attribute(writer, "NORMAL", mesh->normals, count, 3);
    add_attribute(writer, "TEXCOORD_0", mesh->texcoords, count, 2);
    add_attribute(writer, "COLOR_0", mesh->colors, count, 3);
    fputs("}}]}", file);
    return writer->meshes.count - 1;
}

void gltf_node(struct gltf_writer *writer, const char *format, ...)
{
    va_list list;
    va_start(list, format);
    add_text(&writer->nodes, format, list);
    va_end(list);
}

static void add_polygon(struct gltf_writer *writer, int material, const float *corners,
                        uint32_t corner_count)
{
    static const uint32_t fan[] = {0, 1, 2, 0, 2, 3};
    const struct gltf_mesh mesh = {.positions = corners,
                                   .triangles = fan,
                                   .vertex_count = corner_count,
                                   .triangle_count = corner_count - 2};
    gltf_node(writer, "{\"mesh\":%d}", gltf_mesh(writer, material, &mesh));
}

void gltf_triangle(struct gltf_writer *writer, int material, const float *corners)
{
    add_polygon(writer, material, corners, 3);
}

void gltf_quad(struct gltf_writer *writer, int material, const float *corners)
{
    add_polygon(writer, material, corners, 4);
}

void gltf_floor(struct gltf_writer *writer, int material, float y, float half, bool front_up)
{
    const float z = front_up ? half : -half;
    gltf_quad(writer, material,
              (const float[]){-half, y, z, half, y, z, half, y, -z, -half, y, -z});
}

void gltf_room(struct gltf_writer *writer, int material, const float *lo, const float *hi)
{
    // Each wall names its corners by bits: 1 high x, 2 high y, 4 high z.
    static const int walls[6][4] = {{0, 2, 6, 4}, {1, 5, 7, 3}, {0, 4, 5, 1},
                                    {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 6, 7, 5}};
    for (int i = 0; i < 6; i++) {
        float corners[12];
        for (int k = 0; k < 12; k++)
            corners[k] = walls[i][k / 3] >> (k % 3) & 1 ? hi[k % 3] : lo[k % 3];
        gltf_quad(writer, material, corners);
    }
}

// ---- Lights and cameras

static void normalize(double *v)
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int i = 0; i < 3; i++)
        v[i] /= length;
}

static void cross(double *out, const double *a, const double *b)
{
    for (int i = 0; i < 3; i++)
        out[i] = a[(i + 1) % 3] * b[(i + 2) % 3] - a[(i + 2) % 3] * b[(i + 1) % 3];
}

// Adds a node at a place whose -Z axis points to another; `json` is the rest of the node.
static void add_aimed_node(struct gltf_writer *writer, const float *from, const float *to,
                           const char *json)
{
    double x[3], y[3], z[3];
    for (int i = 0; i < 3; i++)
        z[i] = (double)from[i] - to[i];
    normalize(z);
    const double up[3] = {0.0, fabs(z[1]) < 0.999, fabs(z[1]) >= 0.999};
    cross(x, up, z);
    normalize(x);
    cross(y, z, x);
    gltf_node(writer,
              "{\"matrix\":[%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,%.9g,%.9g,%.9g,0,"
              "%.9g,%.9g,%.9g,1],%s}",
              x[0], x[1], x[2], y[0], y[1], y[2], z[0], z[1], z[2], (double)from[0],
              (double)from[1], (double)from[2], json);
}

void gltf_light(struct gltf_writer *writer, const float *position, const float *target,
                const char *format, ...)
{
    va_list list;
    va_start(list, format);
    const int index = add_text(&writer->lights, format, list);
    va_end(list);
    char json[96];
    snprintf(json, sizeof(json), "\"extensions\":{\"KHR_lights_punctual\":{\"light\":%d}}", index);
    add_aimed_node(writer, position, target, json);
}

void gltf_area_light(struct gltf_writer *writer, const float *position, const float *target,
                     const char *format, ...)
{
    va_list list;
    va_start(list, format);
    const int index = add_text(&writer->area_lights, format, list);
    va_end(list);
    char json[96];
    snprintf(json, sizeof(json), "\"extensions\":{\"EXT_lights_area\":{\"light\":%d}}", index);
    add_aimed_node(writer, position, target, json);
}

static void add_camera_node(struct gltf_writer *writer, const float *eye, const float *target)
{
    char json[32];
    snprintf(json, sizeof(json), "\"camera\":%d", writer->cameras.count - 1);
    add_aimed_node(writer, eye, target, json);
}

void gltf_camera(struct gltf_writer *writer, const char *name, const float *eye,
                 const float *target, double yfov_rad)
{
    fprintf(next_element(&writer->cameras),
            "{\"name\":\"%s\",\"type\":\"perspective\",\"perspective\":{\"aspectRatio\":1,"
            "\"yfov\":%.9g,\"znear\":0.01}}",
            name, yfov_rad);
    add_camera_node(writer, eye, target);
}

void gltf_camera_flat(struct gltf_writer *writer, const char *name, const float *eye,
                      const float *target, double half)
{
    fprintf(next_element(&writer->cameras),
            "{\"name\":\"%s\",\"type\":\"orthographic\",\"orthographic\":{\"xmag\":%.9g,"
            "\"ymag\":%.9g,\"znear\":0,\"zfar\":100}}",
            name, half, half);
    add_camera_node(writer, eye, target);
}

void gltf_image_light(struct gltf_writer *writer, const uint8_t *const faces[6], uint32_t size,
                      const char *members)
{
    int first = 0;
    for (int i = 0; i < 6; i++)
        first = add_image(writer, faces[i], size, size) - i;
    fprintf(next_element(&writer->image_lights),
            "{\"specularImageSize\":%u,\"specularImages\":[[%d,%d,%d,%d,%d,%d]],"
            "\"irradianceCoefficients\":[]%s}",
            size, first, first + 1, first + 2, first + 3, first + 4, first + 5, members);
}

// ---- The file

static void write_array(FILE *file, const char *name, struct gltf_section *section)
{
    const char *text = finish_section(section);
    if (section->count > 0)
        fprintf(file, ",\n\"%s\":[%s]", name, text);
}

static void write_file(FILE *file, struct gltf_writer *writer)
{
    fputs("{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[", file);
    for (int i = 0; i < writer->nodes.count; i++)
        fprintf(file, "%s%d", i > 0 ? "," : "", i);
    fputs("]", file);
    if (writer->image_lights.count > 0)
        fputs(",\"extensions\":{\"EXT_lights_image_based\":{\"light\":0}}", file);
    fputs("}]", file);
    write_array(file, "nodes", &writer->nodes);
    write_array(file, "meshes", &writer->meshes);
    write_array(file, "materials", &writer->materials);
    write_array(file, "accessors", &writer->accessors);
    write_array(file, "bufferViews", &writer->views);
    write_array(file, "cameras", &writer->cameras);
    write_array(file, "images", &writer->images);
    write_array(file, "textures", &writer->textures);
    if (writer->textures.count > 0)
        fputs(",\n\"samplers\":[{\"magFilter\":9728,\"minFilter\":9728}]", file);
    if (writer->lights.count + writer->area_lights.count + writer->image_lights.count > 0) {
        fprintf(file, ",\n\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[%s]},",
                finish_section(&writer->lights));
        fprintf(file, "\"EXT_lights_area\":{\"lights\":[%s]},",
                finish_section(&writer->area_lights));
        fprintf(file, "\"EXT_lights_image_based\":{\"lights\":[%s]}}",
                finish_section(&writer->image_lights));
    }
    finish_section(&writer->bytes);
    fprintf(file,
            ",\n\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:application/octet-stream;base64,",
            writer->bytes.size);
    write_base64(file, (const uint8_t *)writer->bytes.text, writer->bytes.size);
    fputs("\"}]}\n", file);
}

struct lk_scene *gltf_load(struct gltf_writer *writer)
{
    char folder[] = "/tmp/lightkiln-test-XXXXXX";
    char path[64];
    assert_non_null(mkdtemp(folder));
    snprintf(path, sizeof(path), "%s/scene.gltf", folder);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    write_file(file, writer);
    fclose(file);
    struct gltf_section *sections = &writer->nodes;
    for (size_t i = 0; i < sizeof(*writer) / sizeof(*sections); i++)
        free_section(&sections[i]);

    struct lk_scene *scene = NULL;
    const enum lk_status status = lk_scene_load(&scene, path);
    unlink(path);
    rmdir(folder);
    if (status != LK_OK)
        fail_msg("%s", lk_error());
    return scene;
}
