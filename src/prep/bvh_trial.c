#include "prep/bvh_trial.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

#include "prep/array.h"
#include "prep/vec3.h"
#include "shared/bvh.h"

#define RAYS   4096u
#define OFFSET 1e-5 // rays begin that part of their origin's size above a triangle
#define PI     3.14159265358979323846

struct trial_ray {
    double org[3], dir[3], inverse[3];
};

static void load_corners(double corners[3][3], const struct geometry *geometry, uint32_t index)
{
    const struct triangle *triangle = &geometry->triangles[index];
    vec3_position(corners[0], &geometry->vertices[triangle->v0]);
    vec3_position(corners[1], &geometry->vertices[triangle->v1]);
    vec3_position(corners[2], &geometry->vertices[triangle->v2]);
}

// A number in [0, 1) that depends on its arguments (S. Vigna, splitmix64).
static double random_unit(uint32_t ray, uint32_t use)
{
    uint64_t z = ((uint64_t)ray * 8 + use + 1) * 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

// Sums what triangles count for, up to each: their size, the root of their surface. Rays of a path
// tracer begin where the surface is, but much of it may be a shell that nobody sees; most triangles
// are where there is the finest detail. In all of five scenes, what lies between the two tells
// which of two trees is cheaper for rays from a camera and their bounces; neither of them does.
static double *sum_sizes(const struct geometry *geometry)
{
    double *sums = array_alloc(geometry->triangle_count, sizeof(*sums));
    double sum = 0.0;
    for (uint32_t i = 0; i < geometry->triangle_count && sums != NULL; i++) {
        double p[3][3], face[3];
        load_corners(p, geometry, i);
        vec3_face(face, p[0], p[1], p[2]);
        sum += sqrt(vec3_length(face));
        sums[i] = sum;
    }
    return sums;
}

// Draws a triangle. `sums` has one.
static uint32_t draw(const double *sums, uint32_t count, double number)
{
    uint32_t first = 0;
    uint32_t last = count - 1;
    while (first < last) {
        const uint32_t middle = first + (last - first) / 2;
        if (sums[middle] > number * sums[count - 1])
            last = middle;
        else
            first = middle + 1;
    }
    return first;
}

// Makes a ray that leaves a triangle. False if that has no normal.
static bool make_ray(struct trial_ray *ray, const struct geometry *geometry, const double *sums,
                     uint32_t index)
{
    double p[3][3], ab[3], ac[3], normal[3];
    load_corners(p, geometry, draw(sums, geometry->triangle_count, random_unit(index, 0)));
    vec3_sub(ab, p[1], p[0]);
    vec3_sub(ac, p[2], p[0]);
    vec3_cross(normal, ab, ac);
    const double length = vec3_length(normal) * (random_unit(index, 1) < 0.5 ? -1.0 : 1.0);
    if (!(fabs(length) > 0.0))
        return false;

    const double root = sqrt(random_unit(index, 2));
    const double v = root * random_unit(index, 3);
    const double z = 1.0 - 2.0 * random_unit(index, 4);
    const double turn = 2.0 * PI * random_unit(index, 5);
    const double radius = sqrt(1.0 - z * z);
    const double sphere[3] = {radius * cos(turn), radius * sin(turn), z};
    double size = 0.0;
    for (int k = 0; k < 3; k++) {
        ray->org[k] = p[0][k] + (root - v) * ab[k] + v * ac[k];
        size = fmax(size, fabs(ray->org[k]));
    }
    for (int k = 0; k < 3; k++) {
        normal[k] /= length;
        ray->org[k] += normal[k] * size * OFFSET;
        ray->dir[k] = normal[k] + sphere[k];
        ray->inverse[k] = 1.0 / (fabs(ray->dir[k]) > 1e-20 ? ray->dir[k] : 1e-20);
    }
    return true;
}

// Where a ray enters a box; DBL_MAX if that is not before `limit`.
static double enter_box(const struct trial_ray *ray, const struct bvh_build_node *node,
                        double limit)
{
    double enter = 0.0;
    for (int k = 0; k < 3; k++) {
        const double a = (node->lo[k] - ray->org[k]) * ray->inverse[k];
        const double b = (node->hi[k] - ray->org[k]) * ray->inverse[k];
        enter = fmax(enter, fmin(a, b));
        limit = fmin(limit, fmax(a, b));
    }
    return enter <= limit ? enter : DBL_MAX;
}

// Where a ray meets a triangle; DBL_MAX if it does not (T. Moeller, B. Trumbore, JGT 1997).
static double meet_triangle(const struct trial_ray *ray, double corners[3][3])
{
    double e1[3], e2[3], s[3], p[3], q[3];
    vec3_sub(e1, corners[1], corners[0]);
    vec3_sub(e2, corners[2], corners[0]);
    vec3_sub(s, ray->org, corners[0]);
    vec3_cross(p, ray->dir, e2);
    vec3_cross(q, s, e1);
    const double det = vec3_dot(e1, p);
    const double u = vec3_dot(s, p) / det;
    const double v = vec3_dot(ray->dir, q) / det;
    const double t = vec3_dot(e2, q) / det;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && t > 0.0 ? t : DBL_MAX;
}

// Traces a ray, the nearer child first. Returns nodes visited and triangles tested.
static uint32_t trace(const struct trial_ray *ray, const struct bvh *bvh,
                      const struct tri_ref *refs, const struct geometry *geometry)
{
    struct {
        uint32_t index;
        double enter;
    } stack[BVH_STACK_SIZE + 1], entry = {0, 0.0};
    uint32_t top = 0;
    uint32_t work = 0;
    double nearest = DBL_MAX;
    for (;;) {
        const struct bvh_build_node *node = &bvh->nodes[entry.index];
        work += node->count > 0 ? node->count : 1;
        for (uint32_t i = node->left; i < node->left + node->count; i++) {
            double corners[3][3];
            load_corners(corners, geometry, refs[bvh->order[i]].triangle);
            nearest = fmin(nearest, meet_triangle(ray, corners));
        }
        if (node->count == 0) {
            const double enter[2] = {enter_box(ray, &bvh->nodes[node->left], nearest),
                                     enter_box(ray, &bvh->nodes[node->left + 1], nearest)};
            const uint32_t nearer = enter[1] < enter[0];
            for (uint32_t i = 0; i < 2; i++) {
                const uint32_t side = i == 0 ? 1 - nearer : nearer;
                stack[top].index = node->left + side;
                stack[top].enter = enter[side];
                top += enter[side] < DBL_MAX;
            }
        }
        do {
            if (top == 0)
                return work;
            entry.index = stack[--top].index;
            entry.enter = stack[top].enter;
        } while (entry.enter > nearest);
    }
}

enum status bvh_trial(double *out, const struct bvh *bvh, const struct tri_ref *refs,
                      const struct geometry *geometry)
{
    uint64_t work = 0;
    *out = 0.0;
    if (bvh->node_count == 0)
        return STATUS_OK;
    double *sums = sum_sizes(geometry);
    if (sums == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to try a BVH of %u triangles",
                           geometry->triangle_count);
#pragma omp parallel for schedule(dynamic, 64) reduction(+ : work)
    for (uint32_t i = 0; i < RAYS; i++) {
        struct trial_ray ray;
        if (make_ray(&ray, geometry, sums, i))
            work += trace(&ray, bvh, refs, geometry);
    }
    free(sums);
    *out = (double)work / RAYS;
    return STATUS_OK;
}
