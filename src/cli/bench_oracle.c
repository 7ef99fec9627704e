#include "cli/bench_oracle.h"

#include <math.h>
#include <stdlib.h>

#define TESTS_MAX  1e8  // ray-triangle tests of one set
#define SAMPLE_MIN 32   // rays, whatever that takes
#define SAMPLE_MAX 1024 // enough
#define SLACK      1e-4 // of a triangle's weights: larger and smaller triangles
#define DISTANCE   1e-4 // relative error of a distance, and of places far from the origin

// Where a ray meets a triangle's plane: t, u, v. False where they are parallel.
static bool meet(double *out, const struct lk_geometry *geometry, uint32_t triangle,
                 const struct lk_ray *ray)
{
    const float *a = ray_corner(geometry, triangle, 0);
    const float *b = ray_corner(geometry, triangle, 1);
    const float *c = ray_corner(geometry, triangle, 2);
    double e1[3], e2[3], s[3], p[3], q[3];
    for (int k = 0; k < 3; k++) {
        e1[k] = (double)b[k] - a[k];
        e2[k] = (double)c[k] - a[k];
        s[k] = (double)ray->org[k] - a[k];
    }
    for (int k = 0; k < 3; k++) {
        const int l = (k + 1) % 3;
        const int m = (k + 2) % 3;
        p[k] = ray->dir[l] * e2[m] - ray->dir[m] * e2[l];
        q[k] = s[l] * e1[m] - s[m] * e1[l];
    }
    const double det = e1[0] * p[0] + e1[1] * p[1] + e1[2] * p[2];
    out[0] = (e2[0] * q[0] + e2[1] * q[1] + e2[2] * q[2]) / det;
    out[1] = (s[0] * p[0] + s[1] * p[1] + s[2] * p[2]) / det;
    out[2] = (ray->dir[0] * q[0] + ray->dir[1] * q[1] + ray->dir[2] * q[2]) / det;
    return det != 0.0;
}

// Finds the nearest hit of larger and of smaller triangles.
static void ask_all(double *least, double *most, const struct lk_geometry *geometry,
                    const struct lk_ray *ray)
{
    *least = *most = INFINITY;
    for (uint32_t i = 0; i < geometry->triangle_count; i++) {
        double hit[3];
        if (!meet(hit, geometry, i, ray) || !(hit[0] > ray->tmin && hit[0] < ray->tmax))
            continue;
        const double inside = fmin(fmin(hit[1], hit[2]), 1.0 - hit[1] - hit[2]);
        if (inside >= -SLACK)
            *least = fmin(*least, hit[0]);
        if (inside >= SLACK)
            *most = fmin(*most, hit[0]);
    }
}

enum status oracle_build(struct oracle *out, const struct lk_geometry *geometry,
                         const struct ray_set *set)
{
    const double affordable = TESTS_MAX / (double)(geometry->triangle_count + 1);
    uint32_t count = (uint32_t)fmin(fmax(affordable, SAMPLE_MIN), SAMPLE_MAX);
    if (count > set->count)
        count = set->count;
    struct oracle oracle = {.count = count, .step = count > 0 ? set->count / count : 1};
    oracle.least = calloc(count + 1, sizeof(double));
    oracle.most = calloc(count + 1, sizeof(double));
    if (oracle.least == NULL || oracle.most == NULL) {
        oracle_free(&oracle);
        return status_fail(STATUS_NO_MEMORY, "no memory for %u rays", count);
    }
#pragma omp parallel for schedule(dynamic)
    for (uint32_t i = 0; i < count; i++)
        ask_all(&oracle.least[i], &oracle.most[i], geometry, &set->rays[(size_t)i * oracle.step]);
    *out = oracle;
    return STATUS_OK;
}

// What a distance may be off by.
static double tolerance(const struct lk_ray *ray, double t)
{
    const double place = fmax(fabs(ray->org[0]), fmax(fabs(ray->org[1]), fabs(ray->org[2])));
    return DISTANCE * (t + place);
}

uint32_t oracle_count_wrong(const struct oracle *oracle, const struct ray_set *set,
                            const struct lk_hit *hits)
{
    uint32_t wrong = 0;
    for (uint32_t i = 0; i < oracle->count; i++) {
        const struct lk_ray *ray = &set->rays[(size_t)i * oracle->step];
        const struct lk_hit *hit = &hits[(size_t)i * oracle->step];
        if (hit->triangle == LK_HIT_NONE) {
            wrong += isfinite(oracle->most[i]);
        } else if (set->any_hit) {
            wrong += !isfinite(oracle->least[i]);
        } else {
            const double slack = tolerance(ray, hit->t);
            wrong += hit->t < oracle->least[i] - slack || hit->t > oracle->most[i] + slack;
        }
    }
    return wrong;
}

void oracle_free(struct oracle *oracle)
{
    free(oracle->least);
    free(oracle->most);
    *oracle = (struct oracle){0};
}
