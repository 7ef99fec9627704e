/**
 * @file
 * Reads glTF 2.0, .gltf and .glb, into a scene.
 *
 * Source: Khronos glTF 2.0 specification and the extensions named in the .cpp. Parsing is
 * tinygltf's, image decoding OpenImageIO's; every index, count, view and number is checked here
 * before it is used.
 */
#ifndef SCENE_GLTF_IMPORT_H
#define SCENE_GLTF_IMPORT_H

#include "core/status.h"
#include "scene/scene.h"

/**
 * Imports the file's default scene, or its first, in rest pose.
 *
 * @param[out] out  Written on success only; release with scene_free().
 * @param path      A file, or "-" for a GLB (or glTF with embedded buffers) on standard input.
 * @retval STATUS_IO           The file, or one that it names, cannot be read.
 * @retval STATUS_FORMAT       Not glTF 2.0, or something in it is out of bounds, not finite, or
 * contradictory.
 * @retval STATUS_UNSUPPORTED  It requires an extension that is not implemented.
 * @retval STATUS_LIMIT        More triangles, vertices or texels than the engine's 31-bit indices
 * reach.
 * @retval STATUS_NO_MEMORY    The scene does not fit.
 */
enum status gltf_import(struct scene *out, const char *path);

#endif
