/**
 * @file
 * A clear sky and its sun, as a lat-long map and a directional light.
 *
 * Source: A. J. Preetham, P. Shirley, B. Smits, "A Practical Analytic Model for Daylight", SIGGRAPH
 * 1999: luminance and chromaticity of the sky (appendix A.2), transmittance of the air (A.1).
 * Differs from it: the sun is a light without extent, with three wavelengths for its colour; below
 * the horizon is a Lambert ground, of albedo 0.2, lit by sky and sun.
 */
#ifndef PREP_SKY_H
#define PREP_SKY_H

#include "shared/light.h"

// Texels of the map: the sky changes slowly, but for the glow about the sun, some degrees wide.
#define SKY_WIDTH  1024u
#define SKY_HEIGHT 512u

struct sky {
    float azimuth_deg;   // of the sun: 0 is -Z, 90 +X
    float elevation_deg; // above the horizon, 0 .. 90
    float turbidity;     // 2 (very clear) .. 10 (haze)
    float strength;      // factor of all; 1: cd/m2 and lux as on Earth
};

/**
 * Fills a map laid out as shared/environment.h says, and its sun.
 *
 * @param[out] texels  [SKY_WIDTH * SKY_HEIGHT], xyz; w is set to 0.
 */
void sky_bake(float4 *texels, struct directional_light *sun, const struct sky *sky);

#endif
