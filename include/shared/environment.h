/**
 * @file
 * The environment: a lat-long map of what comes from far away, as kernels read it.
 *
 * Row 0 is at the zenith (+Y), the middle column looks along -Z, as a glTF camera does, and columns
 * go on to the right, to +X at three quarters. A turn about +Y is counter-clockwise seen from
 * above. Radiance is filtered bilinearly between the middles of texels.
 *
 * Directions are drawn by texel, in proportion to the radiance filtered over it and its solid
 * angle, then evenly over that solid angle: by the alias method (A. J. Walker, 1977; M. D. Vose,
 * 1991), which takes two random numbers however large the map.
 */
#ifndef SHARED_ENVIRONMENT_H
#define SHARED_ENVIRONMENT_H

#include "shared/base.h"

// The map as a whole. Its texels are rows of float4: rgb radiance, cd/m2; w density with which
// directions in the texel are drawn, 1/sr.
struct environment_map {
    uint width, height; // texels, 0 without an environment
    float turn;         // about +Y, in turns
    uint pad0;
};
SHARED_SIZE(environment_map, 16);

// One column of the alias table: a texel, and another one to take instead.
struct environment_alias {
    float keep; // probability of staying
    uint other; // index of the other texel
};
SHARED_SIZE(environment_alias, 8);

#endif
