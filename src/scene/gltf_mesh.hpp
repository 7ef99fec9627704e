/**
 * @file
 * Primitives of a glTF mesh, as triangle lists.
 */
#ifndef SCENE_GLTF_MESH_HPP
#define SCENE_GLTF_MESH_HPP

#include "scene/gltf_context.hpp"

/** How a mesh is bent out of its shape in the file. */
struct mesh_pose {
    const std::vector<double> *weights = nullptr; // of morph targets; NULL: none
    int skin = -1;                                // index into skins, or -1
};

/** A primitive that has become a mesh of the scene. */
struct loaded_primitive {
    uint32_t mesh;    // index into context.meshes
    bool is_in_world; // its skin has moved it there; the node's own transform does not count
};

/** Adds the primitives of a mesh that have triangles to context.meshes. */
std::vector<loaded_primitive> load_mesh(import_context &context, int mesh_index,
                                        const mesh_pose &pose);

#endif
