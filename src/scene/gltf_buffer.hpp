/**
 * @file
 * Bytes that a glTF names: buffers, buffer views, external files and data: URIs.
 */
#ifndef SCENE_GLTF_BUFFER_HPP
#define SCENE_GLTF_BUFFER_HPP

#include "scene/gltf_context.hpp"

/**
 * Reads a whole file, or standard input if `path` is NULL.
 *
 * @param owner  For messages: who needs the file.
 */
std::vector<uint8_t> read_whole_file(const char *path, const std::string &owner);

/** Is it a data: URI? */
bool is_data_uri(const std::string &uri);

/**
 * Fetches what a URI names: a data: URI's content, or a file within the scene's folder. Safe to
 * call from several threads.
 *
 * @param owner  For messages: the buffer or image that names it.
 */
std::vector<uint8_t> fetch_uri(const import_context &context, const std::string &uri,
                               const std::string &owner);

/** The bytes of a buffer view, fetched at the first use; not for several threads at once. */
byte_span view_bytes(import_context &context, int64_t view_index, const std::string &owner);

#endif
