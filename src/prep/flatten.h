/**
 * @file
 * Flattens instances: every placed mesh becomes its own vertices and triangles in world space
 * (thesis section 3.2).
 */
#ifndef PREP_FLATTEN_H
#define PREP_FLATTEN_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "scene/scene.h"
#include "shared/geometry.h"

/** World-space geometry. All zero is a valid empty one. */
struct geometry {
    struct vertex *vertices; // [vertex_count]; owned
    uint2 *colors; // [vertex_count] or NULL: COLOR_0 as four unorm16, r in the low half of x; owned
    uint *tangents; // [vertex_count] tangent_pack(), or NULL where no material has a normal map;
                    // owned
    struct triangle *triangles; // [triangle_count]; owned
    uint32_t vertex_count, triangle_count;
    float lo[3], hi[3]; // bounds, m; all 0 if there is no triangle
};

/**
 * Places every instance. Normals go by the inverse transpose and are renormalised; where the
 * determinant is negative the winding is turned round, so that fronts stay fronts. Zero and
 * non-finite normals become the face's. Tangents go as edges do.
 *
 * @param[out] out  Written on success only; release with geometry_free().
 * @retval STATUS_LIMIT      More than BVH_REF_TRIANGLE triangles or vertices.
 * @retval STATUS_FORMAT     A transform takes a position out of float's range; names the mesh.
 * @retval STATUS_NO_MEMORY  The arrays do not fit.
 */
enum status geometry_build(struct geometry *out, const struct scene *scene);

/** Releases what the geometry owns and leaves it empty. */
void geometry_free(struct geometry *geometry);

#endif
