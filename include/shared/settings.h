/**
 * @file
 * What stays the same for a whole render, in constant memory.
 */
#ifndef SHARED_SETTINGS_H
#define SHARED_SETTINGS_H

#include "shared/base.h"

enum quantity { QUANTITY_RADIANCE = 0, QUANTITY_IRRADIANCE = 1 };

enum light_sampler {
    LIGHT_SAMPLER_TREE = 0,    // thesis, section 3.4
    LIGHT_SAMPLER_UNIFORM = 1, // one of all lights, thesis section 2.4.2
    LIGHT_SAMPLER_ALL = 2      // every light, thesis section 2.4.1
};

struct settings {
    uint seed;
    uint depth;         // shaded hits of a path, 1 .. 255
    uint shadow_rays;   // per hit towards lights of the tree, 1 ..
    uint light_sampler; // enum light_sampler
    uint quantity;      // enum quantity
    uint light_count;   // lights in the tree
    uint directional_count;
    uint material_count;
    uint emitter_count; // lights that a ray can hit
    uint pad0, pad1, pad2;
};
SHARED_SIZE(settings, 48);

#endif
