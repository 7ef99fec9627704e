/**
 * @file
 * Materials, textures and images of a glTF.
 */
#ifndef SCENE_GLTF_MATERIAL_HPP
#define SCENE_GLTF_MATERIAL_HPP

#include "scene/gltf_context.hpp"

/** Checks a primitive's material index, notes that it is used, and returns its index in the scene;
 * -1 names the default material. */
uint32_t use_material(import_context &context, int index, const std::string &owner);

/** The set of texture coordinates, 0 or 1, of the normal map of a primitive's material; -1 if it
 * has none. */
int normal_map_texcoord(const import_context &context, int material);

/**
 * Makes the scene's materials, one for each of the file's and the default one behind them where it
 * is used, the textures that the used ones need, and decodes their images in parallel.
 */
void load_materials(import_context &context);

#endif
