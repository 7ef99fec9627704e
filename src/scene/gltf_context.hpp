/**
 * @file
 * What the parts of the glTF importer share: the parsed document, its bytes, what has been made so
 * far, and how a failure leaves.
 *
 * Inside the importer a failure is a thrown import_failure; gltf_import() turns it into a status.
 */
#ifndef SCENE_GLTF_CONTEXT_HPP
#define SCENE_GLTF_CONTEXT_HPP

#include <cstddef>
#include <cstdint>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include <tiny_gltf.h>

extern "C" {
#include "core/status.h"
#include "scene/scene.h"
}

/** Leaves the importer. */
struct import_failure {
    enum status code;
    std::string message; // without the file's name
};

/** Throws an import_failure. As printf; the file's name is put in front by gltf_import(). */
#ifdef __GNUC__
__attribute__((format(printf, 2, 3)))
#endif
[[noreturn]] void
fail_import(enum status code, const char *format, ...);

/** An element of "buffers" or "images": where bytes come from. */
struct data_source {
    std::string name;         // "" if none
    std::string uri;          // as it stands in the file, data: URIs included; "" if none
    int64_t buffer_view = -1; // images only
    int64_t byte_length = 0;  // buffers only
};

/** Borrowed bytes. */
struct byte_span {
    const uint8_t *data = nullptr;
    size_t size = 0;
};

/** A buffer; its bytes are fetched at the first use. */
struct loaded_buffer {
    std::vector<uint8_t> storage; // owns the bytes, but those of the GLB's own buffer
    byte_span bytes;
    bool is_loaded = false;
};

/** A node placed in the world. */
struct node_pose {
    double to_world[12]; // 3x4, row major
    double rotation[9];  // rotations of the chain alone, row major
    bool is_visible;     // neither it nor an ancestor is hidden by KHR_node_visibility
};

struct import_context {
    const char *path = nullptr; // as given
    const char *name = nullptr; // for messages: the path, or "standard input"
    std::string folder;         // of external files, ends with '/'; "" for the working directory
    bool has_folder = false;    // false: standard input, nothing external can be read
    std::vector<uint8_t> file;  // the file's own bytes
    byte_span binary_chunk;     // of a GLB; within `file`

    tinygltf::Model model;            // without buffers, images and animations
    std::vector<data_source> buffers; // "buffers"
    std::vector<data_source> images;  // "images"
    bool has_animations = false;
    std::vector<loaded_buffer> loaded_buffers; // [buffers.size()]
    std::vector<node_pose> poses;              // [model.nodes.size()]

    struct scene *scene = nullptr; // being filled; its arena owns what it points to
    std::vector<scene_mesh> meshes;
    std::vector<scene_instance> instances;
    std::vector<scene_light> lights;
    std::vector<scene_camera> cameras;
    std::vector<scene_material> materials;
    std::vector<scene_texture> textures;
    std::vector<bool> material_used; // [model.materials.size()]
    std::set<std::string> warned;    // kinds of warnings that have been given
    uint64_t vertex_total = 0;       // of `meshes`
    uint64_t triangle_total = 0;     // of `meshes`
};

/** Gives a warning the first time that one of this kind is asked for. As printf. */
#ifdef __GNUC__
__attribute__((format(printf, 3, 4)))
#endif
void warn_once(import_context &context, const char *kind, const char *format, ...);

/** Allocates zeroed elements in the scene's arena, or leaves with STATUS_NO_MEMORY. */
template <typename T> T *arena_array(import_context &context, size_t count)
{
    T *elements = static_cast<T *>(arena_alloc(&context.scene->arena, count, sizeof(T)));
    if (elements == nullptr)
        fail_import(STATUS_NO_MEMORY, "%zu elements of %zu bytes do not fit", count, sizeof(T));
    return elements;
}

/** Copies a string into the scene's arena. */
const char *arena_text(import_context &context, const std::string &text);

/** How messages call an element: `mesh "door"`, or `mesh 3` if it has no name. */
std::string label(const char *kind, size_t index, const std::string &name);

/** Rounds to float; what is not finite then fails, with the name of the thing. */
float finite_float(double value, const std::string &owner, const char *property);

/** An extension of an element, or NULL. */
const tinygltf::Value *find_extension(const tinygltf::ExtensionMap &extensions, const char *name);

/** A member of an extension that must be a number; `fallback` if it is missing. */
double number_member(const tinygltf::Value &object, const char *name, double fallback,
                     const std::string &owner);

/** A member of an extension that must be an index >= 0; -1 if it is missing. */
int index_member(const tinygltf::Value &object, const char *name, const std::string &owner);

/** A member of an extension that must be `count` numbers; `out` stays as it is if missing. */
void numbers_member(const tinygltf::Value &object, const char *name, float *out, size_t count,
                    const std::string &owner);

#endif
