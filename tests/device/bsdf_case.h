/**
 * @file
 * A hit whose BSDF is tested, for host and device.
 */
#ifndef TESTS_DEVICE_BSDF_CASE_H
#define TESTS_DEVICE_BSDF_CASE_H

#include "shared/material.h"

// What a hit looks like from one side; xyz are unit vectors.
struct bsdf_case {
    float4 normal;    // shading normal, viewer's side
    float4 geometric; // geometric normal, viewer's side
    float4 view;      // to the viewer
    struct material material;
};
SHARED_SIZE(bsdf_case, 848);

// One sampled direction.
struct bsdf_draw {
    float4 dir_density; // xyz unit direction, all 0 if there is none; w density, 1/sr
    float4 weight;      // rgb; w 1 if the mirror was taken, else 0
};
SHARED_SIZE(bsdf_draw, 32);

#endif
