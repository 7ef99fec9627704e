/**
 * @file
 * The node hierarchy of a glTF: where everything stands in the world.
 */
#ifndef SCENE_GLTF_NODE_HPP
#define SCENE_GLTF_NODE_HPP

#include "scene/gltf_context.hpp"

/** Checks that the nodes are a forest and fills context.poses. */
void place_nodes(import_context &context);

/** The nodes of the default scene, else the first; all nodes where there is no scene. Parents come
 * before their children. */
std::vector<int> scene_nodes(import_context &context);

/** The 3x4 matrix, row major, of translation, rotation (a quaternion x, y, z, w) and scale; the
 * rotation alone goes to `rotation` (3x3) if that is not NULL. */
void compose_transform(const double *translation, const double *quaternion, const double *scale,
                       const std::string &owner, double *out, double *rotation);

/** out = a * b, both 3x4, row major. `out` is neither. */
void multiply_transforms(const double *a, const double *b, double *out);

#endif
