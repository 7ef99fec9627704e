/**
 * @file
 * What surfaces that let light by do to a ray that meets them.
 *
 * A ray that looks for a hit meets such a surface or not, by chance: with the share of its
 * strongest colour it goes by, and PASSAGE_TINT corrects the others afterwards. A shadow ray takes
 * the share itself of the first PASSAGE_SURFACES, whatever their order, and chance decides colour
 * by colour beyond. Both estimate the same, so that either way of finding a light may.
 */
#ifndef LIB_PASSAGE_H
#define LIB_PASSAGE_H

#include "lib/math.h"
#include "lib/surface.h"

#define PASSAGE_SURFACES 8u // that a shadow ray takes a share of

// What a traversal asks of surfaces on the way.
#define PASSAGE_CHANCE 0 // whether there is a hit
#define PASSAGE_SHARE  1 // what share of light goes by
#define PASSAGE_TINT   2 // the colour of a ray that has gone by; what it would meet does not count

struct passage {
    float3 share;                     // of light that has come by, for each colour
    uint count;                       // triangles noted
    uint triangles[PASSAGE_SURFACES]; // that `share` contains: a split one is found more than once
    bool tinted;                      // PASSAGE_CHANCE: something coloured was gone through
};

static inline void passage_init(struct passage *passage)
{
    passage->share = (float3)(1.0f);
    passage->count = 0;
    passage->tinted = false;
}

// Asks a triangle. Returns whether the ray goes on.
//
//   mode  constant: PASSAGE_...
static inline bool passage_ask(struct passage *passage, const int mode, const struct surface *s,
                               const uint triangle, const float u, const float v, const float3 org,
                               const float3 dir)
{
    float3 share = surface_passes(s, triangle, u, v, dir);
    const float most = max3(share);
    if (most <= 0.0f)
        return mode == PASSAGE_TINT;
    const bool even = share.x == share.y && share.x == share.z;
    if (even && (most >= 1.0f || mode == PASSAGE_TINT))
        return true;
    if (mode == PASSAGE_CHANCE) {
        const bool goes = surface_number(triangle, org, dir) >= 1.0f - most;
        passage->tinted = passage->tinted || (goes && !even);
        return goes;
    }

    for (uint i = 0; i < passage->count; i++)
        if (passage->triangles[i] == triangle)
            return true;
    const float number = surface_number(triangle, org, dir);
    if (mode == PASSAGE_TINT && number < 1.0f - most)
        return true;
    if (passage->count < PASSAGE_SURFACES) {
        passage->triangles[passage->count++] = triangle;
        passage->share *= mode == PASSAGE_TINT ? share / most : share;
    } else {
        passage->share.x = number >= 1.0f - share.x ? passage->share.x : 0.0f;
        passage->share.y = number >= 1.0f - share.y ? passage->share.y : 0.0f;
        passage->share.z = number >= 1.0f - share.z ? passage->share.z : 0.0f;
    }
    return max3(passage->share) > 0.0f || mode == PASSAGE_TINT;
}

#endif
