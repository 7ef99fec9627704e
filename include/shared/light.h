/**
 * @file
 * Lights and the light tree as kernels read them.
 *
 * Source of the tree: the thesis, section 3.4. A node bounds the affecting spheres of its lights; a
 * shading point descends from the root without a stack, drawing one child where both hold the
 * point.
 *
 * Differs from it: lights without an affecting radius (punctual lights without `range`,
 * emissive surfaces) reach everywhere. They form a subtree of their own with boundless boxes, whose
 * children are drawn in proportion to their power, so that no bias and no preference for a badly
 * balanced branch is added.
 */
#ifndef SHARED_LIGHT_H
#define SHARED_LIGHT_H

#include "shared/base.h"

enum light_type {
    LIGHT_POINT = 0,
    LIGHT_SPOT = 1,
    LIGHT_TRIANGLE = 2,  // one emissive triangle
    LIGHT_RECTANGLE = 3, // two emissive triangles that make a rectangle, or a rectangle of its own
    LIGHT_DISC = 4
};

#define LIGHT_TYPE_MASK   255u // bits of light.color_kind.w: enum light_type
#define LIGHT_TWO_SIDED   256u // bit of it: emits on both sides
#define LIGHT_SHAPE_SHIFT 9u   // bits of it from here on: index of the shape; 0 for points
#define LIGHT_NO_RANGE    0.0f // light.range of a light that reaches everywhere

// One light, world space: what every kind of it has.
struct light {
    float4 org_range;  // xyz position, or a surface's corner or middle, m; w affecting radius, m,
                       // or LIGHT_NO_RANGE
    float4 color_kind; // rgb intensity, cd, or radiance, cd/m2; w bits: type, sides, shape
};
SHARED_SIZE(light, 32);

// What all but points have. A surface is org + s edge_u + t edge_v, with s, t >= 0 and s + t <= 1
// (triangle), 0 <= s, t <= 1 (rectangle), or s^2 + t^2 <= 1 (disc); its front is where
// edge_u x edge_v points. Only triangles can be textured.
struct light_shape {
    float4 edge_u; // xyz edge, m, or a spot's unit axis; w area, m2, or the scale of a spot's
                   // falloff in KHR_lights_punctual
    float4 edge_v; // xyz edge, m; w bits of the (first) triangle, EMITTER_NONE where no ray can hit
                   // the light, or the offset of a spot's falloff
};
SHARED_SIZE(light_shape, 32);

// A directional light: in no tree, it reaches everything.
struct directional_light {
    float4 dir;   // xyz unit direction the light travels
    float4 color; // rgb illuminance on a surface that faces it, lux
};
SHARED_SIZE(directional_light, 32);

// A node's child word: index of the right child (the left one is the next node), or
// LIGHT_NODE_LEAF | light index.
#define LIGHT_NODE_LEAF 0x80000000u

// One node of the tree, depth first, root at 0. Boxes of lights without a range reach from -FLT_MAX
// to FLT_MAX.
struct light_node {
    float4
        lo_left; // xyz lower corner, m; w probability of the left child where both hold the point
    float4 hi_child; // xyz upper corner, m; w bits of the child word
};
SHARED_SIZE(light_node, 32);

// The 8-wide light BVH (prep/light_bvh.h).

#define LIGHT_BVH_WIDTH 8u

// A child word: LIGHT_BVH_LEAF | light index, or the index of a node, or LIGHT_BVH_EMPTY.
#define LIGHT_BVH_LEAF  0x80000000u
#define LIGHT_BVH_EMPTY 0xffffffffu
#define LIGHT_BVH_ROOT  0xffffffffu // light_bvh parents[]: no parent

#define LIGHT_WALK_MOST 8 // lights that a hit takes from it at most, in one round

// What is known of the lights below one child, as rows of 8, one number for each child. A child's
// lights lie in a sphere, shine at most `theta_e` off directions that are at most `theta_o` off the
// axis, with `power` in all, and reach no farther than `range` from where they are.
//
//   row   0 .. 2   centre of the sphere, m
//   row   3        its radius, m
//   row   4        power, cd: sum of intensities, or of radiance times area; negative: two-sided
//   row   5        largest range, m; FLT_MAX without
//   row   6 .. 8   unit axis
//   row   9        cos theta_o
//   row   10       cos theta_e
//   row   11       bits of the child word
struct light_bvh_node {
    float4 rows[24]; // row r is rows[2 r], rows[2 r + 1]
};
SHARED_SIZE(light_bvh_node, 384);

#endif
