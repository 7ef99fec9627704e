/**
 * @file
 * Materials as kernels read them, and all texels in one pool.
 */
#ifndef PREP_TEXTURES_H
#define PREP_TEXTURES_H

#include <stdint.h>

#include "core/status.h"
#include "scene/scene.h"
#include "shared/material.h"

/** All zero is a valid empty one. */
struct material_set {
    struct material *materials; // [material_count]; owned
    uint32_t *texels;           // [texel_count] RGBA8 of every image in use, once; owned
    uint32_t material_count;
    uint64_t texel_count;
};

/**
 * Packs materials and the images they use.
 *
 * @retval STATUS_LIMIT      2^32 texels or more.
 * @retval STATUS_NO_MEMORY  They do not fit.
 */
enum status material_set_build(struct material_set *out, const struct scene *scene);

void material_set_free(struct material_set *set);

#endif
