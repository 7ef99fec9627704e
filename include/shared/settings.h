/**
 * @file
 * What stays the same for a whole render, in constant memory.
 */
#ifndef SHARED_SETTINGS_H
#define SHARED_SETTINGS_H

#include "shared/base.h"

enum quantity { QUANTITY_RADIANCE = 0, QUANTITY_IRRADIANCE = 1 };

// How a hit chooses lights. Kernels are built for one: -D LIGHT_SAMPLER.
#define LIGHT_SAMPLER_TREE       1 // thesis, section 3.4
#define LIGHT_SAMPLER_UNIFORM    2 // one of all lights, thesis section 2.4.2
#define LIGHT_SAMPLER_ALL        3 // every light, thesis section 2.4.1
#define LIGHT_SAMPLER_IMPORTANCE 4 // by estimated contribution, from the light BVH

struct settings {
    uint seed;
    uint depth;       // shaded hits of a path, 1 .. 255
    uint shadow_rays; // per hit towards lights of the tree, 1 ..
    uint quantity;    // enum quantity
    uint light_count; // lights in the tree
    uint directional_count;
    uint material_count;
    uint emitter_count; // lights that a ray can meet: triangles, and the environment
    uint point_shift;   // log2 of the points of a block (lib/samples.h)
    uint triangle_count;
    uint roulette_depth; // hits before Russian roulette may end a path
    uint pad0;
};
SHARED_SIZE(settings, 48);

#endif
