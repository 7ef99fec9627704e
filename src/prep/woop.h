/**
 * @file
 * Woop's matrix of a triangle (shared/bvh.h: struct woop), computed in double precision.
 */
#ifndef PREP_WOOP_H
#define PREP_WOOP_H

#include "shared/bvh.h"

/** Computes the rows of triangle a, b, c ([3] each, m). A degenerate triangle gives all 0. */
void woop_build(struct woop *out, const float *a, const float *b, const float *c);

#endif
