#include "cli/bench_views.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>

#define PLACES      4u  // that a view is chosen from
#define HEADINGS    8u  // at each
#define PROBE_SIDE  16u // rays on a side of a small view, to choose by
#define PROBE_COUNT (PROBE_SIDE * PROBE_SIDE)
#define TURN        0.785398163397448f // radians between headings

struct view {
    float org[3];  // m
    float heading; // radians about +Y
};

// Drops the odd bits and closes the gaps.
static uint32_t even_bits(uint32_t v)
{
    uint32_t out = 0;
    for (uint32_t k = 0; k < 16; k++)
        out |= (v >> k) & (1u << k);
    return out;
}

// Makes side * side rays through the middles of a view's pixels.
static void aim(struct lk_ray *rays, const struct view *view, uint32_t side)
{
    const float ahead[2] = {cosf(view->heading), sinf(view->heading)};
    const uint32_t count = side * side;
    uint32_t made = 0;
    for (uint32_t code = 0; made < count; code++) {
        const uint32_t column = even_bits(code);
        const uint32_t row = even_bits(code >> 1);
        if (column >= side || row >= side)
            continue; // the curve fills a square of a power of two
        const float x = 2.0f * ((float)column + 0.5f) / (float)side - 1.0f;
        const float y = 1.0f - 2.0f * ((float)row + 0.5f) / (float)side;
        const float scale = 1.0f / sqrtf(1.0f + x * x + y * y);
        rays[made++] = (struct lk_ray){
            .org = {view->org[0], view->org[1], view->org[2]},
            .dir = {scale * (ahead[0] - x * ahead[1]), scale * y,
                    scale * (ahead[1] + x * ahead[0])},
            .tmax = FLT_MAX,
        };
    }
}

// How far a view sees on average, m.
static enum status look(double *out, struct lk_tracer *tracer, const struct view *view)
{
    struct lk_ray rays[PROBE_COUNT];
    struct lk_hit hits[PROBE_COUNT];
    const struct ray_set set = {.rays = rays, .count = PROBE_COUNT};
    aim(rays, view, PROBE_SIDE);
    const enum status status = ray_set_trace(hits, tracer, &set);
    if (status != STATUS_OK)
        return status;
    *out = 0.0;
    for (uint32_t i = 0; i < PROBE_COUNT; i++)
        if (hits[i].triangle != LK_HIT_NONE)
            *out += hits[i].t / (double)PROBE_COUNT;
    return STATUS_OK;
}

// Finds the first segment from `start` on that has a hit, and what is half way along it.
static enum status find_place(struct view *out, const struct ray_set *segments,
                              const struct lk_hit *hits, uint32_t start)
{
    for (uint32_t k = 0; k < segments->count; k++) {
        const uint32_t i = (start + k) % segments->count;
        if (hits[i].triangle == LK_HIT_NONE)
            continue;
        for (int axis = 0; axis < 3; axis++)
            out->org[axis] =
                segments->rays[i].org[axis] + 0.5f * hits[i].t * segments->rays[i].dir[axis];
        return STATUS_OK;
    }
    return status_fail(STATUS_UNSUPPORTED,
                       "no path of the camera has three hits, half way between which views could "
                       "stand; use --views 1");
}

// Chooses one of the views.
static enum status choose(struct view *out, struct lk_tracer *tracer,
                          const struct ray_set *segments, const struct lk_hit *hits, uint32_t index,
                          uint32_t views)
{
    double farthest = -1.0;
    for (uint32_t k = 0; k < PLACES * HEADINGS; k++) {
        const double share = (index + (k / HEADINGS + 0.5) / PLACES) / views;
        struct view view = {.heading = (float)(k % HEADINGS) * TURN};
        double distance = 0.0;
        enum status status = find_place(&view, segments, hits, (uint32_t)(share * segments->count));
        if (status == STATUS_OK)
            status = look(&distance, tracer, &view);
        if (status != STATUS_OK)
            return status;
        if (distance > farthest) {
            farthest = distance;
            *out = view;
        }
    }
    return STATUS_OK;
}

enum status views_make(struct ray_set *out, struct lk_tracer *tracer,
                       const struct ray_set *segments, const struct lk_hit *hits, uint32_t views)
{
    const struct lk_tracer_info *info = lk_tracer_info(tracer);
    const uint32_t side = (uint32_t)sqrt((double)info->width * info->height / views);
    struct ray_set made = {.count = views * side * side};
    if (side < PROBE_SIDE)
        return status_fail(STATUS_USAGE,
                           "%u views of %u x %u pixels are too small; --width and --height must "
                           "leave %u x %u to each",
                           views, side, side, PROBE_SIDE, PROBE_SIDE);
    made.rays = malloc((made.count + 1) * sizeof(*made.rays));
    if (made.rays == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u rays", made.count);
    for (uint32_t i = 0; i < views; i++) {
        struct view view = {0};
        const enum status status = choose(&view, tracer, segments, hits, i, views);
        if (status != STATUS_OK) {
            free(made.rays);
            return status;
        }
        aim(made.rays + (size_t)i * side * side, &view, side);
    }
    *out = made;
    return STATUS_OK;
}
