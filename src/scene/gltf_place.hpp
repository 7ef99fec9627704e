/**
 * @file
 * What hangs on the nodes of a glTF: mesh instances, lights and cameras, in the world.
 */
#ifndef SCENE_GLTF_PLACE_HPP
#define SCENE_GLTF_PLACE_HPP

#include "scene/gltf_context.hpp"

/** Adds what the visible ones of these nodes carry. */
void place_contents(import_context &context, const std::vector<int> &nodes);

#endif
