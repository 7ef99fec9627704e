/**
 * @file
 * The vertices of one primitive while it is read, and what bends them: morph targets and skins, at
 * rest.
 */
#ifndef SCENE_GLTF_SHAPE_HPP
#define SCENE_GLTF_SHAPE_HPP

#include "scene/gltf_context.hpp"
#include "scene/gltf_mesh.hpp"

/** Vertices as the file has them; arrays that it lacks are NULL. All live in the scene's arena. */
struct shape {
    size_t vertex_count = 0;
    float *positions = nullptr; // [vertex_count * 3]
    float *normals = nullptr;   // [vertex_count * 3], unit
    float *tangents = nullptr;  // [vertex_count * 4], w the sign of the bitangent
    float *uv0 = nullptr;       // [vertex_count * 2]
    float *uv1 = nullptr;       // [vertex_count * 2]
    float *colors = nullptr;    // [vertex_count * 4]
};

/** Adds the morph targets of a primitive, each times its weight. */
void apply_morph(import_context &context, const tinygltf::Primitive &primitive,
                 const std::vector<double> &weights, const std::string &owner, shape &shape);

/** Moves the vertices to the world with the joints of a skin at rest. A primitive without joints
 * stays as it is: false. */
bool apply_skin(import_context &context, const tinygltf::Primitive &primitive, int skin_index,
                const std::string &owner, shape &shape);

/** Makes all normals unit vectors; those that have no length take the normal of their triangles. */
void normalize_normals(import_context &context, const std::string &owner, shape &shape,
                       const uint32_t *indices, size_t triangle_count);

/** The unit normal of a triangle; some unit vector if it has no area. */
void face_normal(const float *a, const float *b, const float *c, float *out);

#endif
