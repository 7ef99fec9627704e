/**
 * @file
 * Tangents for normal maps, where a file brings none.
 *
 * Source: M. Mikkelsen, "Simulation of Wrinkled Surfaces Revisited", 2008, and the conventions of
 * his MikkTSpace, which glTF names: directions of growing u on each triangle, projected onto the
 * plane of the vertex normal and averaged by angle over the triangles that share position, normal,
 * texture coordinates and handedness. Differs from it: triangles that share a vertex count as one
 * group even if no chain of common edges joins them.
 */
#ifndef SCENE_GLTF_TANGENT_HPP
#define SCENE_GLTF_TANGENT_HPP

#include "scene/gltf_shape.hpp"

/**
 * Makes shape.tangents. A vertex between triangles of either handedness is split in two; the list
 * then names the new one. Where texture coordinates say nothing, any direction serves.
 *
 * @param shape  Its normals are unit vectors.
 * @param uv     [shape.vertex_count * 2] coordinates of the normal map; NULL if there are none.
 * @param list   Corners of triangles.
 */
void make_tangents(import_context &context, shape &shape, const float *uv,
                   std::vector<uint32_t> &list);

/** Makes every tangent a unit vector at a right angle to its normal, and every w 1 or -1. */
void repair_tangents(shape &shape);

#endif
