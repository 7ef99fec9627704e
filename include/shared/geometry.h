/**
 * @file
 * What is known of a surface beside the acceleration structure: vertices and triangles, world
 * space.
 */
#ifndef SHARED_GEOMETRY_H
#define SHARED_GEOMETRY_H

#include "shared/base.h"

#define EMITTER_NONE 0xffffffffu // triangle_emitters[] of a triangle that is no light

// One corner. Corners are shared by the triangles of one instance.
struct vertex {
    float4 pos_normal; // xyz position, m; w bits of the unit shading normal, oct_pack()
    float4 uv;         // xy TEXCOORD_0; zw TEXCOORD_1; 0 where missing
};
SHARED_SIZE(vertex, 32);

// Counter-clockwise seen from the front; instances with negative determinant have been turned
// round.
struct triangle {
    uint v0, v1, v2; // indices into vertices
    uint material;   // index into materials
};
SHARED_SIZE(triangle, 16);

#endif
