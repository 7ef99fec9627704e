/**
 * @file
 * Early split clipping: references to triangles, big ones cut into several with tighter boxes.
 *
 * Source: M. Ernst, G. Greiner, "Early Split Clipping for Bounding Volume Hierarchies", RT 2007
 * (thesis section 3.1): a reference whose box has a surface above the threshold is cut in half
 * across its longest axis, until none is above it.
 */
#ifndef PREP_PRESPLIT_H
#define PREP_PRESPLIT_H

#include <stdint.h>

#include "core/status.h"
#include "prep/flatten.h"

/** A part of a triangle that a leaf refers to. */
struct tri_ref {
    float lo[3], hi[3]; // box of the part, m
    uint32_t triangle;  // index into geometry.triangles
};

/**
 * Makes the references of a geometry. Degenerate triangles (no area in float) get none, since no
 * ray can hit them.
 *
 * @param[out] out        [*out_count], to be released with free(); written on success only.
 * @param area_threshold  Largest surface of a reference's box, m2; 0: no splitting, one reference a
 * triangle.
 * @retval STATUS_LIMIT      The threshold is so small that references pass 2^26, BVH's reach.
 * @retval STATUS_NO_MEMORY  They do not fit.
 */
enum status presplit(struct tri_ref **out, uint32_t *out_count, const struct geometry *geometry,
                     float area_threshold);

#endif
