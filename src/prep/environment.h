/**
 * @file
 * The environment: what lights the scene from far away, from an image, a model of the sky or one
 * colour, and how directions towards it are drawn (shared/environment.h).
 */
#ifndef PREP_ENVIRONMENT_H
#define PREP_ENVIRONMENT_H

#include <stdbool.h>
#include <stdint.h>

#include "core/status.h"
#include "shared/environment.h"
#include "shared/light.h"

struct scene_environment;

/** What is asked for: a file, or a sky, or a background; else what the scene has, if anything. */
struct environment_request {
    const char *path;                    // lat-long image; NULL: none
    float rotation_deg;                  // of an image about +Y, the scene's own included
    float strength;                      // factor of an image, or of sky and sun
    float background[3];                 // radiance from everywhere, cd/m2; all 0: none
    float sky_azimuth_deg;               // of the sun: 0 is -Z, 90 +X
    float sky_elevation_deg;             // above the horizon, up to 90; 0: no sky
    float sky_turbidity;                 // 2 .. 10
    const struct scene_environment *own; // the scene's; NULL or of no size: none
};

/** All zero is a valid empty one. */
struct environment {
    struct environment_map map;
    float4 *texels;                  // [width * height]; owned
    struct environment_alias *alias; // [width * height]; owned
    struct directional_light sun;    // black without one
    bool has_sun;
};

/**
 * Makes the environment; an empty one if nothing is asked for or all is black.
 *
 * @retval STATUS_IO, STATUS_FORMAT  The file cannot be read; or holds a number that is not finite.
 * @retval STATUS_NO_MEMORY          It does not fit.
 */
enum status environment_build(struct environment *out, const struct environment_request *request);

/** Bytes on the device. */
uint64_t environment_size(const struct environment *environment);

void environment_free(struct environment *environment);

#endif
