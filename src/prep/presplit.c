#include "prep/presplit.h"

#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include "prep/array.h"
#include "prep/vec3.h"
#include "shared/bvh.h"

#define REF_LIMIT  (1u << (31u - BVH_LEAF_BITS)) // references that a child word reaches
#define BLOCK_SIZE 4096u                         // triangles that one thread takes at a time
// Corners of a triangle cut by six planes. A convex polygon gains one with each, which makes 9;
// where rounding leaves it not quite convex, n corners become at most 3 n / 2: 4, 6, 9, 13, 19, 28.
#define POLYGON_MAX 28
#define PART_STACK                                                                                 \
    1024 // more than a path of cuts can be long: floats halve less than 280 times an axis

// A part of a triangle in the making.
struct part {
    float lo[3], hi[3];
};

// Cuts off what lies beyond a plane (Sutherland and Hodgman): keeps sign * p[axis] <= sign * at.
// Returns the number of corners left.
static int clip_plane(double polygon[POLYGON_MAX][3], int count, int axis, double at, double sign)
{
    bool beyond = false;
    for (int i = 0; i < count; i++)
        beyond = beyond || sign * (polygon[i][axis] - at) > 0.0;
    if (!beyond)
        return count;

    double in[POLYGON_MAX][3];
    int kept = 0;
    memcpy(in, polygon, (size_t)count * sizeof(in[0]));
    for (int i = 0; i < count; i++) {
        const double *a = in[i];
        const double *b = in[i + 1 < count ? i + 1 : 0];
        const double da = sign * (a[axis] - at);
        const double db = sign * (b[axis] - at);
        if (da <= 0.0)
            memcpy(polygon[kept++], a, sizeof(in[0]));
        if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) {
            const double t = da / (da - db);
            for (int k = 0; k < 3; k++)
                polygon[kept][k] = a[k] + t * (b[k] - a[k]);
            polygon[kept++][axis] = at;
        }
    }
    return kept;
}

// Shrinks a part's box to the triangle inside it. False if nothing of the triangle is inside.
static bool shrink(struct part *part, double corners[3][3])
{
    double polygon[POLYGON_MAX][3];
    int count = 3;
    memcpy(polygon, corners, sizeof(double[3][3]));
    for (int axis = 0; axis < 3; axis++) {
        count = clip_plane(polygon, count, axis, part->lo[axis], -1.0);
        count = clip_plane(polygon, count, axis, part->hi[axis], 1.0);
    }
    if (count == 0)
        return false;

    for (int axis = 0; axis < 3; axis++) {
        double lo = polygon[0][axis];
        double hi = polygon[0][axis];
        for (int i = 1; i < count; i++) {
            lo = fmin(lo, polygon[i][axis]);
            hi = fmax(hi, polygon[i][axis]);
        }
        part->lo[axis] = fmaxf(part->lo[axis], float_below(lo));
        part->hi[axis] = fminf(part->hi[axis], float_above(hi));
    }
    return true;
}

// Cuts a part in half across its longest axis. False if it is as small as float can tell.
static bool halve(struct part *left, struct part *right, const struct part *part,
                  double corners[3][3])
{
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if ((double)part->hi[k] - part->lo[k] > (double)part->hi[axis] - part->lo[axis])
            axis = k;
    const float middle = (float)(0.5 * ((double)part->lo[axis] + part->hi[axis]));
    if (!(part->lo[axis] < middle && middle < part->hi[axis]))
        return false;

    *left = *part;
    *right = *part;
    left->hi[axis] = middle;
    right->lo[axis] = middle;
    return shrink(left, corners) && shrink(right, corners);
}

static double surface(const struct part *part)
{
    const double x = (double)part->hi[0] - part->lo[0];
    const double y = (double)part->hi[1] - part->lo[1];
    const double z = (double)part->hi[2] - part->lo[2];
    return 2.0 * (x * y + y * z + z * x);
}

// Makes the references of one triangle and returns how many; stops when there are more than
// `limit`. Stores them unless `out` is NULL.
static uint32_t split_triangle(struct tri_ref *out, const struct geometry *geometry, uint32_t index,
                               double threshold, uint32_t limit)
{
    const struct triangle *triangle = &geometry->triangles[index];
    double corners[3][3], normal[3];
    vec3_position(corners[0], &geometry->vertices[triangle->v0]);
    vec3_position(corners[1], &geometry->vertices[triangle->v1]);
    vec3_position(corners[2], &geometry->vertices[triangle->v2]);
    vec3_face(normal, corners[0], corners[1], corners[2]);
    const double double_area = vec3_length(normal);
    if (!(double_area > 0.0))
        return 0; // degenerate

    // Half a box's surface is no less than the area inside it: do not try what cannot succeed.
    if (threshold > 0.0 && double_area / threshold > limit)
        return limit + 1;

    // Take the whole triangle, then cut until nothing on the stack is above the threshold.
    struct part stack[PART_STACK];
    int depth = 1;
    uint32_t count = 0;
    for (int k = 0; k < 3; k++) {
        stack[0].lo[k] = (float)fmin(corners[0][k], fmin(corners[1][k], corners[2][k]));
        stack[0].hi[k] = (float)fmax(corners[0][k], fmax(corners[1][k], corners[2][k]));
    }
    while (depth > 0 && count <= limit) {
        const struct part part = stack[--depth];
        if (threshold > 0.0 && surface(&part) > threshold && depth + 2 <= PART_STACK &&
            halve(&stack[depth + 1], &stack[depth], &part, corners)) {
            depth += 2;
            continue;
        }
        if (out != NULL) {
            memcpy(out[count].lo, part.lo, sizeof(part.lo));
            memcpy(out[count].hi, part.hi, sizeof(part.hi));
            out[count].triangle = index;
        }
        count++;
    }
    return count;
}

// Splits all triangles of one block. Returns the number of references, or more than the limit.
static uint32_t split_block(struct tri_ref *out, const struct geometry *geometry, uint32_t block,
                            double threshold)
{
    const uint32_t first = block * BLOCK_SIZE;
    const uint32_t left = geometry->triangle_count - first;
    const uint32_t last = first + (left < BLOCK_SIZE ? left : BLOCK_SIZE);
    uint32_t count = 0;
    for (uint32_t i = first; i < last && count <= REF_LIMIT; i++)
        count += split_triangle(out != NULL ? out + count : NULL, geometry, i, threshold,
                                REF_LIMIT - count);
    return count;
}

// Finds where the references of each block begin, and how many there are in all.
static uint64_t count_refs(uint64_t *first, const struct geometry *geometry, uint32_t block_count,
                           double threshold)
{
    uint64_t sum = 0; // never decides but whether to give up
#pragma omp parallel for schedule(dynamic)
    for (uint32_t i = 0; i < block_count; i++) {
        uint64_t so_far;
#pragma omp atomic read
        so_far = sum;
        first[i] = so_far <= REF_LIMIT ? split_block(NULL, geometry, i, threshold) : 0;
#pragma omp atomic update
        sum += first[i];
    }

    uint64_t next = 0;
    for (uint32_t i = 0; i < block_count; i++) {
        const uint64_t count = first[i];
        first[i] = next;
        next += count;
    }
    return next;
}

enum status presplit(struct tri_ref **out, uint32_t *out_count, const struct geometry *geometry,
                     float area_threshold)
{
    enum status status = STATUS_OK;
    struct tri_ref *refs = NULL;
    const uint32_t block_count =
        (uint32_t)(((uint64_t)geometry->triangle_count + BLOCK_SIZE - 1) / BLOCK_SIZE);
    uint64_t *first = array_alloc(block_count, sizeof(*first)); // first reference of each block
    if (first == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to split %u triangles",
                           geometry->triangle_count);

    // Count, then store: the second round repeats the first, and no buffer has to grow.
    const uint64_t count = count_refs(first, geometry, block_count, area_threshold);
    if (count > REF_LIMIT) {
        status = status_fail(STATUS_LIMIT,
                             area_threshold > 0.0f
                                 ? "splitting makes more than %u parts of triangles: raise "
                                   "--split-threshold"
                                 : "more than %u triangles",
                             REF_LIMIT);
        goto cleanup;
    }
    refs = array_alloc(count, sizeof(*refs));
    if (refs == NULL) {
        status =
            status_fail(STATUS_NO_MEMORY, "no memory for %u parts of triangles", (uint32_t)count);
        goto cleanup;
    }
#pragma omp parallel for schedule(dynamic)
    for (uint32_t i = 0; i < block_count; i++)
        split_block(refs + first[i], geometry, i, area_threshold);

    *out = refs;
    *out_count = (uint32_t)count;

cleanup:
    free(first);
    return status;
}
