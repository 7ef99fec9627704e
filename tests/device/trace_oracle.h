/**
 * @file
 * What a ray meets, by T. Moeller and B. Trumbore in double precision over all triangles.
 *
 * Kernels compute in float, so a ray may pass an edge on the other side than the oracle says, or
 * find the farther of two triangles that are equally far. How far float can be off is bounded for
 * each ray and triangle from the sizes of the terms; what lies within the bound is left open, all
 * else is decided.
 */
#ifndef TESTS_DEVICE_TRACE_ORACLE_H
#define TESTS_DEVICE_TRACE_ORACLE_H

#include <math.h>
#include <stdbool.h>

#include "prep/prep_support.h"
#include "prep/woop.h"
#include "shared/ray.h"

// Part of the sum of all terms that Woop's test may be off by: a row is rounded once, and a sum of
// four products four times, 2^-24 each; the quotient adds up to three.
#define WOOP_EPSILON 0x1p-21

enum verdict {
    VERDICT_MISS,
    VERDICT_OPEN, // float may say so or so
    VERDICT_HIT
};

/** One ray and one triangle: where they meet, and how far float may be off. */
struct meeting {
    enum verdict verdict;
    double t, u, v;
    double t_error, u_error, v_error; // t_error is infinite where ray and plane are parallel
};

/** What is asked of the nearest hit of a ray. */
struct expectation {
    double limit; // no hit may be farther; INFINITY if there need not be one
    bool open;    // there is an open triangle before that
};

static inline double oracle_dot(const float4 row, const double *p)
{
    return (double)row.x * p[0] + (double)row.y * p[1] + (double)row.z * p[2];
}

// The sum of the sizes of the terms.
static inline double oracle_sizes(const float4 row, const double *p)
{
    return fabs(row.x * p[0]) + fabs(row.y * p[1]) + fabs(row.z * p[2]);
}

// What a weight is off by at p, which itself is off by p_error.
static inline double oracle_weight_error(const float4 row, const double *p, const double *p_error)
{
    return oracle_sizes(row, p_error) + WOOP_EPSILON * (oracle_sizes(row, p) + fabs(row.w));
}

static inline void oracle_load(double *org, double *dir, const struct ray *ray)
{
    const double o[3] = {ray->org.x, ray->org.y, ray->org.z};
    const double d[3] = {ray->dir.x, ray->dir.y, ray->dir.z};
    memcpy(org, o, sizeof(o));
    memcpy(dir, d, sizeof(d));
}

// Decides from the numbers.
static inline enum verdict oracle_decide(const struct meeting *m, const struct ray *ray)
{
    const double tmin = ray->org.w;
    const double tmax = ray->dir.w;
    const double third = 1.0 - m->u - m->v;
    const double third_error = m->u_error + m->v_error;
    if (m->u < -m->u_error || m->v < -m->v_error || third < -third_error ||
        m->t + m->t_error <= tmin || m->t - m->t_error >= tmax)
        return VERDICT_MISS;
    if (m->u > m->u_error && m->v > m->v_error && third > third_error && m->t - m->t_error > tmin &&
        m->t + m->t_error < tmax)
        return VERDICT_HIT;
    return VERDICT_OPEN;
}

/** What a ray and a triangle do. Triangles without Woop rows are not there. */
static inline struct meeting oracle_meet(const struct geometry *geometry, uint32_t triangle,
                                         const struct ray *ray)
{
    static const struct woop none;
    const struct triangle *tri = &geometry->triangles[triangle];
    const uint corner[3] = {tri->v0, tri->v1, tri->v2};
    struct meeting m = {.verdict = VERDICT_MISS, .t_error = INFINITY};
    float narrow[3][3];
    double wide[3][3], org[3], dir[3], tuv[3];
    for (int i = 0; i < 3; i++) {
        memcpy(narrow[i], &geometry->vertices[corner[i]].pos_normal, sizeof(narrow[i]));
        for (int k = 0; k < 3; k++)
            wide[i][k] = narrow[i][k];
    }
    oracle_load(org, dir, ray);
    struct woop rows;
    woop_build(&rows, narrow[0], narrow[1], narrow[2]);
    const double slant_sizes = oracle_sizes(rows.row_w, dir);
    const double slant = fabs(oracle_dot(rows.row_w, dir));
    if (memcmp(&rows, &none, sizeof(rows)) == 0 || slant_sizes == 0.0)
        return m; // not there, or parallel in float, too
    if (!moeller_trumbore(tuv, org, dir, wide) || slant <= WOOP_EPSILON * slant_sizes) {
        m.verdict = VERDICT_OPEN;
        return m;
    }

    // Carry the error of the distance on to the weights.
    double p[3], p_error[3];
    m.t = tuv[0];
    m.u = tuv[1];
    m.v = tuv[2];
    m.t_error =
        WOOP_EPSILON *
        ((oracle_sizes(rows.row_w, org) + fabs(rows.row_w.w) + fabs(m.t) * slant_sizes) / slant +
         fabs(m.t));
    for (int k = 0; k < 3; k++) {
        p[k] = org[k] + m.t * dir[k];
        p_error[k] = WOOP_EPSILON * (fabs(org[k]) + fabs(m.t * dir[k])) + m.t_error * fabs(dir[k]);
    }
    m.u_error = oracle_weight_error(rows.row_u, p, p_error);
    m.v_error = oracle_weight_error(rows.row_v, p, p_error);
    m.verdict = oracle_decide(&m, ray);
    return m;
}

/**
 * What to expect of a ray.
 *
 * @param absent  [triangle_count] triangles that are not there, or NULL: all are.
 */
static inline struct expectation oracle_expect(const struct geometry *geometry, const bool *absent,
                                               const struct ray *ray)
{
    struct expectation e = {INFINITY, false};
    double open = INFINITY; // the nearest open one
    for (uint32_t i = 0; i < geometry->triangle_count; i++) {
        if (absent != NULL && absent[i])
            continue;
        const struct meeting m = oracle_meet(geometry, i, ray);
        if (m.verdict == VERDICT_HIT)
            e.limit = fmin(e.limit, m.t + m.t_error);
        if (m.verdict == VERDICT_OPEN)
            open = fmin(open, isinf(m.t_error) ? 0.0 : m.t - m.t_error);
    }
    e.open = open < e.limit;
    return e;
}

/** Whether a hit may be: of a triangle that is there and in reach, at its place. */
static inline bool oracle_is_hit(const struct geometry *geometry, const bool *absent,
                                 const struct ray *ray, const struct hit *hit)
{
    if (hit->triangle >= geometry->triangle_count || (absent != NULL && absent[hit->triangle]))
        return false;
    const struct meeting m = oracle_meet(geometry, hit->triangle, ray);
    if (m.verdict == VERDICT_OPEN && isinf(m.t_error))
        return true;
    return m.verdict != VERDICT_MISS && fabs(hit->t - m.t) <= m.t_error &&
           fabs(hit->u - m.u) <= m.u_error && fabs(hit->v - m.v) <= m.v_error;
}

/** Whether a hit may be the nearest. */
static inline bool oracle_accepts(const struct geometry *geometry, const bool *absent,
                                  const struct expectation *expectation, const struct ray *ray,
                                  const struct hit *hit)
{
    if (hit->triangle == HIT_NONE)
        return isinf(expectation->limit);
    return oracle_is_hit(geometry, absent, ray, hit) && hit->t <= expectation->limit;
}

#endif
