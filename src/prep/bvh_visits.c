#include "prep/bvh_visits.h"

#include <math.h>
#include <string.h>

// A ray on its way.
struct visitor {
    float org[3], dir[3];
    float inverse[3]; // of the direction, made safe to divide by
    float tmin, t;    // what is looked between; t shrinks with every hit
};

// Where a ray enters a box; INFINITY if it misses it.
static float enter(const struct visitor *v, const float *planes[3])
{
    float near = v->tmin;
    float far = v->t;
    for (int k = 0; k < 3; k++) {
        const float a = (planes[k][0] - v->org[k]) * v->inverse[k];
        const float b = (planes[k][1] - v->org[k]) * v->inverse[k];
        near = fmaxf(near, fminf(a, b));
        far = fminf(far, fmaxf(a, b));
    }
    return near <= far ? near : INFINITY;
}

// A row of Woop's matrix times a point, or a direction with w 0.
static float along(float4 row, const float *v, float w)
{
    return row.x * v[0] + row.y * v[1] + row.z * v[2] + row.w * w;
}

static bool meets(struct visitor *v, const struct woop *woop)
{
    const float t = -along(woop->row_w, v->org, 1.0f) / along(woop->row_w, v->dir, 0.0f);
    if (!(t > v->tmin && t < v->t))
        return false;
    const float p[3] = {v->org[0] + t * v->dir[0], v->org[1] + t * v->dir[1],
                        v->org[2] + t * v->dir[2]};
    const float x = along(woop->row_u, p, 1.0f);
    const float y = along(woop->row_v, p, 1.0f);
    if (!(x >= 0.0f && y >= 0.0f && x + y <= 1.0f))
        return false;
    v->t = t;
    return true;
}

static struct visitor begin(const struct ray *ray)
{
    struct visitor v = {
        .org = {ray->org.x, ray->org.y, ray->org.z},
        .dir = {ray->dir.x, ray->dir.y, ray->dir.z},
        .tmin = ray->org.w,
        .t = ray->dir.w,
    };
    for (int k = 0; k < 3; k++)
        v.inverse[k] = 1.0f / (fabsf(v.dir[k]) < 1e-20f ? copysignf(1e-20f, v.dir[k]) : v.dir[k]);
    return v;
}

void bvh_count_visits(struct bvh_visits *sum, const struct packed_bvh *bvh, const struct ray *ray,
                      bool any_hit)
{
    struct visitor v = begin(ray);
    int32_t stack[BVH_STACK_SIZE];
    int top = 0;
    stack[top++] = 0;
    while (top > 0) {
        const int32_t word = stack[--top];
        if (word < 0) {
            const uint32_t first = (uint32_t)~word >> BVH_LEAF_BITS;
            for (uint32_t i = first; i < first + ((uint32_t)~word & BVH_LEAF_MAX); i++) {
                sum->references++;
                if (meets(&v, &bvh->woop[i]) && any_hit)
                    return;
            }
            continue;
        }
        const struct bvh_node *node = &bvh->nodes[word];
        const float *left[3] = {&node->row0.x, &node->row0.z, &node->row2.x};
        const float *right[3] = {&node->row1.x, &node->row1.z, &node->row2.z};
        const float enters[2] = {enter(&v, left), enter(&v, right)};
        int32_t words[2];
        memcpy(words, &node->row3, sizeof(words));
        sum->nodes++;

        // The nearer comes last, and is visited next.
        const int nearer = enters[1] < enters[0];
        if (enters[1 - nearer] < INFINITY)
            stack[top++] = words[1 - nearer];
        if (enters[nearer] < INFINITY)
            stack[top++] = words[nearer];
    }
}
