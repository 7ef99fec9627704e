/**
 * @file
 * From a file's bytes to a parsed document: container, JSON, extensions.
 *
 * tinygltf parses the JSON, but fetches nothing: "buffers" and "images" are taken out beforehand
 * and kept as data_source, so that every byte that comes from elsewhere passes gltf_buffer.cpp and
 * its rules.
 */
#ifndef SCENE_GLTF_DOCUMENT_HPP
#define SCENE_GLTF_DOCUMENT_HPP

#include "scene/gltf_context.hpp"

/** Reads context.path and fills file, binary_chunk, folder, model, buffers and images. Refuses
 * required extensions that are not implemented, and versions other than 2. */
void load_document(import_context &context);

#endif
