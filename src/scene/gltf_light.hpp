/**
 * @file
 * The lights of nodes: KHR_lights_punctual, and EXT_lights_area (the draft of Khronos' pull request
 * 2525: one-sided rectangles and discs along -Z, as large as the node's largest scale makes them).
 */
#ifndef SCENE_GLTF_LIGHT_HPP
#define SCENE_GLTF_LIGHT_HPP

#include "scene/gltf_context.hpp"

/** Places the lights of a node, if it has any. */
void place_lights(import_context &context, int node_index);

#endif
