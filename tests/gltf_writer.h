/**
 * @file
 * Makes small glTF scenes for tests: add materials, surfaces, lights and cameras, then load the
 * whole as a scene. The file is one .gltf text with data: URIs in a temporary folder; it is gone
 * after loading.
 *
 * Every gltf_ function fails the running test if it cannot do its work. All-zero is an empty scene.
 * Points are [3], metres; what is aimed needs a target elsewhere.
 */
#ifndef TESTS_GLTF_WRITER_H
#define TESTS_GLTF_WRITER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "lightkiln/lightkiln.h"

/** One growing array of the file. */
struct gltf_section {
    FILE *file; // open_memstream() into text
    char *text;
    size_t size;
    int count; // elements so far
};

/** A scene in the making. */
struct gltf_writer {
    struct gltf_section nodes, meshes, materials, accessors, views, lights, area_lights, cameras,
        images, textures, image_lights;
    struct gltf_section bytes; // the buffer
};

/** A mesh of one primitive. */
struct gltf_mesh {
    const float *positions;    // [vertex_count * 3]
    const float *normals;      // [vertex_count * 3] or NULL
    const float *texcoords;    // [vertex_count * 2] or NULL
    const float *colors;       // [vertex_count * 3], linear, or NULL
    const uint32_t *triangles; // [triangle_count * 3]
    uint32_t vertex_count, triangle_count;
};

/** Adds a material, given as the text of its JSON object; returns its index. */
int gltf_material(struct gltf_writer *writer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/** Adds a Lambert material of one grey (KHR_materials_specular with specularFactor 0). */
int gltf_lambert(struct gltf_writer *writer, double albedo);

/** Adds a Lambert material that emits `radiance`, cd/m2, the same in R, G and B. */
int gltf_emitter(struct gltf_writer *writer, double albedo, double radiance, bool double_sided);

/** Adds a mesh; returns its index. It is seen where a node shows it. */
int gltf_mesh(struct gltf_writer *writer, int material, const struct gltf_mesh *mesh);

/** Adds a node of the scene's root, given as the text of its JSON object. */
void gltf_node(struct gltf_writer *writer, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/** Adds a triangle, corners [9], front where they run counter-clockwise. */
void gltf_triangle(struct gltf_writer *writer, int material, const float *corners);

/** Adds a quadrilateral of two triangles, corners [12], front where they run counter-clockwise. */
void gltf_quad(struct gltf_writer *writer, int material, const float *corners);

/** Adds a level square of 2 `half` on a side about (0, y, 0), front up or down. */
void gltf_floor(struct gltf_writer *writer, int material, float y, float half, bool front_up);

/** Adds a box whose fronts look inwards. */
void gltf_room(struct gltf_writer *writer, int material, const float *lo, const float *hi);

/** Adds a light of KHR_lights_punctual, given as the text of its JSON object, at a place and
 * shining towards another. */
void gltf_light(struct gltf_writer *writer, const float *position, const float *target,
                const char *format, ...) __attribute__((format(printf, 4, 5)));

/** The same for a light of EXT_lights_area. */
void gltf_area_light(struct gltf_writer *writer, const float *position, const float *target,
                     const char *format, ...) __attribute__((format(printf, 4, 5)));

/** Adds a camera that looks from a place at another; yfov in radians. */
void gltf_camera(struct gltf_writer *writer, const char *name, const float *eye,
                 const float *target, double yfov_rad);

/** Adds an orthographic camera that sees a square of 2 `half` on a side about `target`. */
void gltf_camera_flat(struct gltf_writer *writer, const char *name, const float *eye,
                      const float *target, double half);

/** Adds a texture of RGBA bytes [width * height * 4], rows from the top, unfiltered; returns its
 * index. */
int gltf_texture(struct gltf_writer *writer, const uint8_t *rgba, uint32_t width, uint32_t height);

/** Gives the scene a light of EXT_lights_image_based: faces RGBA [6][size * size * 4] in the
 * extension's order, rows from the top; other members as JSON text that begins with a comma, or "".
 */
void gltf_image_light(struct gltf_writer *writer, const uint8_t *const faces[6], uint32_t size,
                      const char *members);

/** Loads what has been added as a scene, for lk_scene_free(), and empties the writer. */
struct lk_scene *gltf_load(struct gltf_writer *writer);

#endif
