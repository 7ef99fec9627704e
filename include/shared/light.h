/**
 * @file
 * Lights and the light tree as kernels read them.
 *
 * Source of the tree: the thesis, section 3.4. A node bounds the affecting spheres of its lights; a shading point
 * descends from the root without a stack, drawing one child where both hold the point.
 * Differs from it: lights without an affecting radius (punctual lights without `range`, emissive surfaces) reach everywhere.
 * They form a subtree of their own with infinite boxes, whose children are drawn in proportion to their power, so that no
 * bias and no preference for a badly balanced branch is added.
 */
#ifndef SHARED_LIGHT_H
#define SHARED_LIGHT_H

#include "shared/base.h"

enum light_type {
    LIGHT_POINT = 0,
    LIGHT_SPOT = 1,
    LIGHT_TRIANGLE = 2, // one emissive triangle
    LIGHT_RECTANGLE = 3 // two emissive triangles that make a rectangle
};

#define LIGHT_TWO_SIDED 256u  // bit of light.kind: emits on both sides
#define LIGHT_TYPE_MASK 255u  // bits of light.kind: enum light_type
#define LIGHT_NO_RANGE 0.0f   // light.range of a light that reaches everywhere

// One light, world space.
//
//               point     spot                      triangle / rectangle
//   org         position  position                  first corner
//   edge_u      -         unit axis, away from it   from it to the second corner
//   edge_v      -         -                         from it to the third corner (rectangle: the far end of the other side)
//   cone        -         scale, offset             u, v: UV-free; area, m2 in cone_scale
struct light {
    float4 org_range;  // xyz; w affecting radius, m, or LIGHT_NO_RANGE
    float4 color_kind; // rgb intensity, cd, or radiance (factor of it where textured); w bits: light_type | LIGHT_TWO_SIDED
    float4 edge_u;     // xyz; w spot: scale; triangle, rectangle: area, m2
    float4 edge_v;     // xyz; w spot: offset; triangle: bits of its triangle index; rectangle: bits of the first triangle's
};
SHARED_SIZE(light, 64);

// A directional light: in no tree, it reaches everything.
struct directional_light {
    float4 dir;   // xyz unit direction the light travels
    float4 color; // rgb illuminance on a surface that faces it, lux
};
SHARED_SIZE(directional_light, 32);

// light_node.child: index of the right child (the left one is the next node), or LIGHT_NODE_LEAF | light index.
#define LIGHT_NODE_LEAF 0x80000000u

// One node of the tree, depth first, root at 0.
struct light_node {
    float4 lo_left;  // xyz lower corner, m, may be -infinity; w probability of the left child where both hold the point
    float4 hi_child; // xyz upper corner, m, may be +infinity; w bits of the child word
};
SHARED_SIZE(light_node, 32);

#endif
