/**
 * @file
 * The textures of a material, without code for uses that no material of the scene has one for.
 */
#ifndef LIB_TEXTURE_USE_H
#define LIB_TEXTURE_USE_H

#include "lib/texture.h"

#ifndef UNTEXTURED
#define UNTEXTURED 0 // bits of enum texture_use
#endif

#define TEXTURE_IS_USED(use) ((UNTEXTURED >> (use)&1u) == 0u)

// As texture_fetch().
//
//   use  constant
static inline float4 texture_fetch_use(TEXTURE_SOURCE source,
                                       __global const struct material *material, const uint use,
                                       const float4 uv)
{
    return TEXTURE_IS_USED(use) ? texture_fetch(source, &material->textures[use], uv)
                                : (float4)(1.0f);
}

#endif
