/**
 * @file
 * Rays that are hard to trace, and scenes that are hard to hit.
 */
#ifndef TESTS_DEVICE_TRACE_RAYS_H
#define TESTS_DEVICE_TRACE_RAYS_H

#include <float.h>
#include <math.h>
#include <stdbool.h>

#include "prep/prep_support.h"
#include "shared/ray.h"

/** Kinds of rays; make_rays() makes all of them in turn. */
enum ray_kind {
    RAY_AIMED,  // from anywhere to a point inside a triangle
    RAY_RANDOM, // from anywhere to anywhere
    RAY_AXIS,   // along an axis to a point inside a triangle
    RAY_CORNER, // starts level with a corner: on a face of a box
    RAY_EDGE,   // starts on a triangle's edge line and runs along it: in its plane
    RAY_SHORT,  // aimed, but ends somewhere on the way
    RAY_LATE,   // aimed, but begins somewhere on the way
    RAY_KINDS
};

static inline void load_corner(double *out, const struct geometry *geometry, uint32_t vertex)
{
    out[0] = geometry->vertices[vertex].pos_normal.x;
    out[1] = geometry->vertices[vertex].pos_normal.y;
    out[2] = geometry->vertices[vertex].pos_normal.z;
}

// A point inside a random triangle and two of its corners; anywhere if there is no triangle.
static inline void pick_target(double *point, double *a, double *b, const struct geometry *geometry,
                               uint64_t *seed)
{
    for (int k = 0; k < 3; k++)
        point[k] = a[k] = b[k] = random_between(seed, -1.0, 1.0);
    if (geometry->triangle_count == 0)
        return;
    const uint32_t i = (uint32_t)(random_unit(seed) * geometry->triangle_count);
    const struct triangle *tri = &geometry->triangles[i];
    double c[3];
    load_corner(a, geometry, tri->v0);
    load_corner(b, geometry, tri->v1);
    load_corner(c, geometry, tri->v2);
    const double u = random_between(seed, 0.05, 0.45);
    const double v = random_between(seed, 0.05, 0.45);
    for (int k = 0; k < 3; k++)
        point[k] = a[k] + u * (b[k] - a[k]) + v * (c[k] - a[k]);
}

// A ray from org towards a point; along axis 0, 1 or 2 if the two are the same.
static inline struct ray aim(const double *org, const double *to, int axis)
{
    double dir[3], length = 0.0;
    for (int k = 0; k < 3; k++) {
        dir[k] = to[k] - org[k];
        length += dir[k] * dir[k];
    }
    length = sqrt(length);
    for (int k = 0; k < 3; k++)
        dir[k] = length > 0.0 ? dir[k] / length : (k == axis);
    struct ray ray = {{(float)org[0], (float)org[1], (float)org[2], 0.0f},
                      {(float)dir[0], (float)dir[1], (float)dir[2], FLT_MAX}};
    return ray;
}

/** One ray of a kind; `reach` is how far from its target it starts at most on each axis, m. */
static inline struct ray make_ray(const struct geometry *geometry, enum ray_kind kind, double reach,
                                  uint64_t *seed)
{
    double target[3], a[3], b[3], org[3];
    pick_target(target, a, b, geometry, seed);
    const int axis = (int)(random_unit(seed) * 3.0);
    for (int k = 0; k < 3; k++)
        org[k] = target[k] + random_between(seed, -reach, reach);
    if (kind == RAY_RANDOM)
        for (int k = 0; k < 3; k++)
            target[k] += random_between(seed, -reach, reach);
    if (kind == RAY_AXIS)
        for (int k = 0; k < 3; k++)
            org[k] = k == axis ? org[k] : target[k];
    if (kind == RAY_CORNER) {
        org[axis] = a[axis];
        target[axis] = random_unit(seed) < 0.5 ? a[axis] : target[axis];
    }
    if (kind == RAY_EDGE) {
        const double back = random_between(seed, 0.0, 2.0);
        for (int k = 0; k < 3; k++) {
            org[k] = a[k] - back * (b[k] - a[k]);
            target[k] = b[k];
        }
    }
    struct ray ray = aim(org, target, axis);
    const double way = sqrt((target[0] - org[0]) * (target[0] - org[0]) +
                            (target[1] - org[1]) * (target[1] - org[1]) +
                            (target[2] - org[2]) * (target[2] - org[2]));
    if (kind == RAY_SHORT)
        ray.dir.w = (float)(way * random_between(seed, 0.0, 2.0));
    if (kind == RAY_LATE)
        ray.org.w = (float)(way * random_between(seed, 0.0, 2.0));
    return ray;
}

static inline void make_rays(struct ray *out, uint32_t count, const struct geometry *geometry,
                             double reach, uint64_t seed)
{
    for (uint32_t i = 0; i < count; i++)
        out[i] = make_ray(geometry, (enum ray_kind)(i % RAY_KINDS), reach, &seed);
}

static inline float *corner_of(struct geometry *geometry, uint32_t triangle, int corner)
{
    return &geometry->vertices[3 * (size_t)triangle + (size_t)corner].pos_normal.x;
}

/** Every fifth triangle of a soup becomes a point, a line or nearly one. */
static inline struct geometry make_slivers(uint64_t seed, uint32_t count)
{
    struct geometry geometry = make_soup(seed, count, 1.0, 0.5);
    for (uint32_t i = 0; i < count; i += 5) {
        const float *a = corner_of(&geometry, i, 0);
        float *b = corner_of(&geometry, i, 1);
        float *c = corner_of(&geometry, i, 2);
        const float aside = (float)pow(10.0, -1.0 - i % 4); // height of a sliver over its width
        for (int k = 0; k < 3; k++) {
            if (i % 15 == 0)
                b[k] = a[k];
            c[k] =
                i % 15 < 10 ? 0.5f * (a[k] + b[k]) : 0.5f * (a[k] + b[k]) + aside * (c[k] - a[k]);
        }
    }
    return geometry;
}

/** A soup of sizes from 10^-3 to 10^3 m. */
static inline struct geometry make_sizes(uint64_t seed, uint32_t count)
{
    struct geometry geometry = make_soup(seed, count, 1.0, 1.0);
    for (uint32_t i = 0; i < count; i++) {
        const float size = (float)pow(10.0, (int)(i % 7) - 3);
        const float *a = corner_of(&geometry, i, 0);
        for (int corner = 1; corner < 3; corner++)
            for (int k = 0; k < 3; k++)
                corner_of(&geometry, i, corner)[k] =
                    a[k] + size * (corner_of(&geometry, i, corner)[k] - a[k]);
    }
    return geometry;
}

/** Moves everything by `by` metres on each axis. */
static inline void move_geometry(struct geometry *geometry, float by)
{
    for (uint32_t i = 0; i < geometry->vertex_count; i++) {
        float *p = &geometry->vertices[i].pos_normal.x;
        for (int k = 0; k < 3; k++)
            p[k] += by;
    }
}

/** Squares of 1 m across each axis on whole metres: 3 axes, 3 planes of 2 x 2, two triangles each.
 */
static inline struct geometry make_walls(void)
{
    float corners[3 * 3 * 2 * 2 * 2][9];
    uint32_t count = 0;
    for (int axis = 0; axis < 3; axis++) {
        for (int place = 0; place < 3 * 2 * 2 * 2; place++) {
            const int half = place & 1;
            const int at[3] = {place >> 3, (place >> 1) & 1, (place >> 2) & 1};
            for (int corner = 0; corner < 3; corner++) {
                float *p = corners[count] + 3 * corner;
                p[axis] = (float)at[0];
                p[(axis + 1) % 3] = (float)(at[1] + (corner == 1 || (half && corner > 0)));
                p[(axis + 2) % 3] = (float)(at[2] + (corner == 2 || (half && corner == 0)));
            }
            count++;
        }
    }
    return make_geometry(corners[0], count);
}

#endif
