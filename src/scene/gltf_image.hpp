/**
 * @file
 * Textures and images of a glTF: only those that a used material names are decoded.
 */
#ifndef SCENE_GLTF_IMAGE_HPP
#define SCENE_GLTF_IMAGE_HPP

#include <cstdlib>
#include <map>
#include <memory>

#include "scene/gltf_context.hpp"

/** The textures and images that have been asked for. */
struct texture_collector {
    std::map<int, int32_t> textures;       // of the file -> of the scene
    std::map<int, int32_t> images;         // of the file -> of the scene
    std::vector<int> image_sources;        // scene's image -> the file's
    std::vector<std::string> image_owners; // scene's image -> first material that names it
};

/** Adds a texture of the file to the scene if it is not there yet, and returns its index. */
int32_t use_texture(import_context &context, texture_collector &collector, int index,
                    const std::string &owner);

/** One decoded image of the file. */
struct decoded_image {
    std::unique_ptr<uint8_t, decltype(&std::free)> rgba{nullptr, &std::free}; // rows from the top
    uint32_t width = 0, height = 0;                                           // texels
};

/** Decodes an image by its index in the file, for something other than a texture. */
decoded_image decode_image(import_context &context, int index, const std::string &owner);

/** Decodes all images that have been asked for, in parallel, into the scene. */
void load_images(import_context &context, const texture_collector &collector);

#endif
