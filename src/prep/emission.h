/**
 * @file
 * How much a triangle of an emissive material emits: its texture's mean over the triangle itself,
 * so that lights are drawn in proportion to what they send out.
 *
 * In: scene and flattened geometry. Out: mean luminances for emitters.
 * The mean is taken of a grid of points; what the grid misses is bounded by the brightest texel
 * that the triangle touches, found in a pyramid of maxima: a triangle is dark only if nothing of it
 * can emit.
 */
#ifndef PREP_EMISSION_H
#define PREP_EMISSION_H

#include <stdint.h>

#include "core/status.h"
#include "prep/flatten.h"
#include "scene/scene.h"

/** Mean luminance of every triangle, cd/m2. All zero is a valid empty one. */
struct emission {
    double *materials; // [material_count] luminance of the factor alone; 0: emits nothing; owned
    float *triangles;  // [triangle_count] with the texture; NULL if no emissive material has one;
                       // owned
};

/**
 * Finds what every triangle emits.
 *
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status emission_build(struct emission *out, const struct scene *scene,
                           const struct geometry *geometry);

/** Mean luminance of one triangle, cd/m2; 0 if nothing of it can emit. */
double emission_of(const struct emission *emission, const struct geometry *geometry,
                   uint32_t triangle);

void emission_free(struct emission *emission);

#endif
