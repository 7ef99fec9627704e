/**
 * @file
 * Vectors of three doubles, as preparation computes with them.
 */
#ifndef PREP_VEC3_H
#define PREP_VEC3_H

#include <float.h>
#include <math.h>

#include "shared/geometry.h"

static inline void vec3_load(double *out, const float *v)
{
    for (int k = 0; k < 3; k++)
        out[k] = v[k];
}

static inline void vec3_sub(double *out, const double *a, const double *b)
{
    for (int k = 0; k < 3; k++)
        out[k] = a[k] - b[k];
}

static inline double vec3_dot(const double *a, const double *b)
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static inline double vec3_length(const double *v)
{
    return sqrt(vec3_dot(v, v));
}

/** `out` may not be one of the factors. */
static inline void vec3_cross(double *out, const double *a, const double *b)
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

/** The cross product of the edges from a: along the front's normal, as long as twice the area. */
static inline void vec3_face(double *out, const double *a, const double *b, const double *c)
{
    double ab[3], ac[3];
    vec3_sub(ab, b, a);
    vec3_sub(ac, c, a);
    vec3_cross(out, ab, ac);
}

/** The position of a vertex, m. */
static inline void vec3_position(double *out, const struct vertex *vertex)
{
    out[0] = vertex->pos_normal.x;
    out[1] = vertex->pos_normal.y;
    out[2] = vertex->pos_normal.z;
}

/** The largest float that is not above x, within +-FLT_MAX. */
static inline float float_below(double x)
{
    const float f = (float)fmin(fmax(x, -FLT_MAX), FLT_MAX);
    return (double)f > x && f > -FLT_MAX ? nextafterf(f, -FLT_MAX) : f;
}

/** The smallest float that is not below x, within +-FLT_MAX. */
static inline float float_above(double x)
{
    return -float_below(-x);
}

#endif
