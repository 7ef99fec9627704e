/**
 * @file
 * What the tests of prep/ share: random numbers from a fixed seed, and geometry made of loose
 * triangles.
 */
#ifndef TESTS_PREP_SUPPORT_H
#define TESTS_PREP_SUPPORT_H

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "prep/flatten.h"

/** A uniform number in [0, 1) (S. Vigna, splitmix64). */
static inline double random_unit(uint64_t *state)
{
    uint64_t z = (*state += 0x9e3779b97f4a7c15u);
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/** A uniform number in [lo, hi). */
static inline double random_between(uint64_t *state, double lo, double hi)
{
    return lo + (hi - lo) * random_unit(state);
}

/** Geometry of `count` triangles of three corners each, [count * 9]; for geometry_free(). */
static inline struct geometry make_geometry(const float *corners, uint32_t count)
{
    struct geometry geometry = {.vertex_count = 3 * count, .triangle_count = count};
    geometry.vertices = calloc(3 * (size_t)count + 1, sizeof(*geometry.vertices));
    geometry.triangles = calloc((size_t)count + 1, sizeof(*geometry.triangles));
    for (uint32_t i = 0; i < 3 * count; i++)
        memcpy(&geometry.vertices[i].pos_normal, corners + 3 * (size_t)i, 3 * sizeof(float));
    for (uint32_t i = 0; i < count; i++)
        geometry.triangles[i] = (struct triangle){3 * i, 3 * i + 1, 3 * i + 2, 0};
    return geometry;
}

/** Random triangles: the first corner within +-range, the others within +-size of it. */
static inline struct geometry make_soup(uint64_t seed, uint32_t count, double range, double size)
{
    float *corners = malloc(9 * (size_t)count * sizeof(*corners));
    for (uint32_t i = 0; i < count; i++) {
        for (int k = 0; k < 3; k++) {
            const double org = random_between(&seed, -range, range);
            corners[9 * (size_t)i + k] = (float)org;
            corners[9 * (size_t)i + 3 + k] = (float)(org + random_between(&seed, -size, size));
            corners[9 * (size_t)i + 6 + k] = (float)(org + random_between(&seed, -size, size));
        }
    }
    struct geometry geometry = make_geometry(corners, count);
    free(corners);
    return geometry;
}

/**
 * Where a ray meets a triangle, by T. Moeller and B. Trumbore in double precision: out is t, u, v.
 *
 * @return False if the ray runs along the plane.
 */
static inline int moeller_trumbore(double *out, const double *org, const double *dir,
                                   double corners[3][3])
{
    double e1[3], e2[3], s[3], p[3], q[3];
    for (int k = 0; k < 3; k++) {
        e1[k] = corners[1][k] - corners[0][k];
        e2[k] = corners[2][k] - corners[0][k];
        s[k] = org[k] - corners[0][k];
    }
    for (int k = 0; k < 3; k++) {
        p[k] = dir[(k + 1) % 3] * e2[(k + 2) % 3] - dir[(k + 2) % 3] * e2[(k + 1) % 3];
        q[k] = s[(k + 1) % 3] * e1[(k + 2) % 3] - s[(k + 2) % 3] * e1[(k + 1) % 3];
    }
    const double det = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
    out[0] = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / det;
    out[1] = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) / det;
    out[2] = (dir[0] * q[0] + dir[1] * q[1] + dir[2] * q[2]) / det;
    return det != 0.0;
}

#endif
