/**
 * @file
 * Collects what emits light: punctual and area lights, rectangles and triangles of emissive
 * surfaces, directional lights.
 */
#ifndef PREP_EMITTERS_H
#define PREP_EMITTERS_H

#include <stdint.h>

#include "core/status.h"
#include "prep/flatten.h"
#include "scene/scene.h"
#include "shared/light.h"

/** All zero is a valid set of no lights. */
struct emitters {
    struct light *lights;        // [light_count], those of the hierarchy; owned
    struct light_shape *shapes;  // [shape_count], those of all lights but points; owned
    float *power;                // [light_count] luminous power, lm, > 0; owned
    uint32_t *triangle_emitters; // [triangle_count] index into lights or EMITTER_NONE; NULL if none
                                 // emits; owned
    struct directional_light *directional; // [directional_count]; owned
    uint32_t light_count, shape_count, directional_count;
    uint32_t point_count, spot_count, rectangle_count, disc_count, triangle_count; // by type
    uint32_t emissive_triangles; // triangles that emit, in rectangles or alone
};

/**
 * Collects the emitters of a scene. Lights of no power are left out, emissive triangles whose
 * texture is black all over them, too (prep/emission.h). Two consecutive triangles of
 * one material, neither textured nor masked, that make a rectangle become one LIGHT_RECTANGLE.
 * Unlit materials do not emit.
 *
 * @retval STATUS_LIMIT      2^22 lights or more (shared/rng.h counts them in 22 bits).
 * @retval STATUS_NO_MEMORY  They do not fit.
 */
enum status emitters_build(struct emitters *out, const struct scene *scene,
                           const struct geometry *geometry);

void emitters_free(struct emitters *emitters);

#endif
