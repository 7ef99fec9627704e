/**
 * @file
 * Numbers of accessors: every component type, normalised or not, interleaved, sparse or without
 * data.
 */
#ifndef SCENE_GLTF_ACCESSOR_HPP
#define SCENE_GLTF_ACCESSOR_HPP

#include "scene/gltf_context.hpp"

/** The accessor of this index; fails if there is none. */
const tinygltf::Accessor &find_accessor(const import_context &context, int index,
                                        const std::string &owner);

/** Numbers in an element: 1 to 4, or 16 for MAT4. */
int component_count(const tinygltf::Accessor &accessor);

/** Elements of an accessor, once it is sure that they have this many components and that the data
 * is there, so that memory for them can be made. */
size_t checked_count(import_context &context, int index, int components, const std::string &owner);

/**
 * Reads all elements as float. All values are finite.
 *
 * @param[out] out          [accessor's count * components].
 * @param components        What an element must have.
 * @param force_normalized  Whole numbers are normalised even if the accessor does not say so.
 * @param owner             For messages: `mesh "door", primitive 0: POSITION`.
 */
void read_floats(import_context &context, int index, int components, bool force_normalized,
                 const std::string &owner, float *out);

/** Reads whole numbers (indices, joints) without normalising. `out` has the accessor's count times
 * `components` elements. */
void read_integers(import_context &context, int index, int components, const std::string &owner,
                   uint32_t *out);

#endif
