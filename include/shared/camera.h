/**
 * @file
 * The camera as raygen reads it. x runs right over 0 .. width, y down over 0 .. height, both in
 * pixels.
 */
#ifndef SHARED_CAMERA_H
#define SHARED_CAMERA_H

#include "shared/base.h"

// A point on the film is p = corner + x right + y down, relative to org.
// Perspective:  the ray starts at org and runs along p.
// Orthographic: the ray starts at org + p and runs along forward.
struct camera {
    float4 org;        // xyz eye, m
    float4 corner;     // xyz of the film's upper left corner
    float4 right;      // xyz of one pixel to the right
    float4 down;       // xyz of one pixel downwards
    float4 forward;    // xyz unit direction of view
    uint width;        // pixels
    uint height;       // pixels
    uint orthographic; // 0 or 1
    uint pad0;
};
SHARED_SIZE(camera, 96);

#endif
