// Figures 7 to 10: how an irradiance image gets nearer to its reference.

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench_results.h"

#define REFERENCE_SEED 1000003u // its noise is nobody else's
#define SPP_LEAST      4.0      // a curve has at least so many samples a pixel
#define END_SHARE      0.1      // of its time that is not worth another render

// The mean of several renders, and what they took.
struct blend {
    double *sum; // [count], weighted by samples per pixel; owned
    float *mean; // [count]; owned
    size_t count;
    uint32_t width, height;
    struct bench_point point; // so far; variance is that of the mean
};

static void blend_free(struct blend *blend)
{
    free(blend->sum);
    free(blend->mean);
    *blend = (struct blend){0};
}

// Adds a finished render and finds the variance of the mean: thesis section 4.2.2.
static enum status blend_add(struct blend *blend, const struct lk_image *image,
                             const struct lk_image *reference)
{
    const float *truth = lk_image_pixels(reference, &blend->width, &blend->height);
    const float *pixels = lk_image_pixels(image, &blend->width, &blend->height);
    const struct lk_render_info *info = lk_image_info(image);
    if (blend->sum == NULL) {
        blend->count = (size_t)blend->width * blend->height * 3;
        blend->sum = calloc(blend->count, sizeof(*blend->sum));
        blend->mean = calloc(blend->count, sizeof(*blend->mean));
        if (blend->sum == NULL || blend->mean == NULL)
            return status_fail(STATUS_NO_MEMORY, "bench: not enough memory for an image");
    }
    blend->point.spp += info->spp;
    blend->point.time_s += info->time_s.render;
    blend->point.rays += (double)(info->rays_camera + info->rays_indirect + info->rays_shadow);
    double squares = 0.0;
    for (size_t i = 0; i < blend->count; i++) {
        blend->sum[i] += (double)pixels[i] * info->spp;
        const double mean = blend->sum[i] / blend->point.spp;
        const double difference = mean - (double)truth[i];
        blend->mean[i] = (float)mean;
        squares += difference * difference;
    }
    blend->point.variance = squares / ((double)blend->count / 3.0);
    return STATUS_OK;
}

// Renders 1, 1, 2, 4, 8 ... samples per pixel until the time is spent, each with a seed of its own,
// and notes the variance of what there is after each.
static enum status measure_curve(struct bench_curve *out, struct blend *blend,
                                 struct lk_scene *scene, const struct lk_settings *base,
                                 const struct lk_image *reference, const struct bench_plan *plan)
{
    struct lk_settings settings = *base;
    while (out->count < BENCH_POINTS_MAX) {
        struct lk_image *image = NULL;
        settings.spp = blend->point.spp < 1.0 ? 1u : (uint32_t)blend->point.spp;
        settings.seed = base->seed + out->count;
        const double left_s = plan->converge_s - blend->point.time_s;
        const double each_s = blend->point.time_s / blend->point.spp; // NaN at first
        if (out->count > 0 && settings.spp * each_s > left_s)
            settings.spp = left_s > END_SHARE * plan->converge_s ? (uint32_t)(left_s / each_s) : 0;
        if (settings.spp == 0 && blend->point.spp < SPP_LEAST)
            settings.spp = 1;
        if (settings.spp == 0)
            break;
        enum status status = bench_render(&image, scene, &settings, plan);
        if (status == STATUS_OK)
            status = blend_add(blend, image, reference);
        lk_image_free(image);
        if (status != STATUS_OK)
            return status;
        out->points[out->count++] = blend->point;
    }
    return STATUS_OK;
}

// Reads the reference from the folder that was given, or renders it and keeps it.
static enum status make_reference(struct lk_image **out, struct bench_view *view,
                                  struct lk_scene *scene, const struct lk_settings *base,
                                  const struct bench_plan *plan)
{
    char name[160];
    char path[4096];
    const char *given = plan->options->reference;
    snprintf(name, sizeof(name), "reference_%s.exr", view->name);
    enum status status = bench_path(path, sizeof(path), given != NULL ? given : plan->folder, name);
    if (status != STATUS_OK)
        return status;
    if (given != NULL) {
        uint32_t width = 0;
        uint32_t height = 0;
        status = (enum status)lk_image_read(out, path);
        if (status != STATUS_OK)
            return status;
        lk_image_pixels(*out, &width, &height);
        if (width != base->width || height != base->height)
            return status_fail(STATUS_FORMAT, "%s: it is %u x %u pixels, not %u x %u", path, width,
                               height, base->width, base->height);
        return STATUS_OK;
    }
    struct lk_settings settings = *base;
    settings.light_sampler = LK_LIGHTS_AUTO;
    settings.seed = base->seed + REFERENCE_SEED;
    settings.time_s = plan->reference_s;
    status = bench_render(out, scene, &settings, plan);
    if (status != STATUS_OK)
        return status;
    view->reference_spp = lk_image_info(*out)->spp;
    view->reference_s = lk_image_info(*out)->time_s.render;
    return (enum status)lk_image_write(*out, path, NULL);
}

// Figure 9: direct light alone, and all of it.
static enum status draw_references(struct lk_scene *scene, const struct lk_settings *base,
                                   const struct lk_image *reference, const struct bench_view *view,
                                   const struct bench_plan *plan)
{
    char name[160];
    struct lk_image *direct = NULL;
    struct lk_settings settings = *base;
    settings.light_sampler = LK_LIGHTS_AUTO;
    settings.depth = 1;
    settings.time_s = plan->picture_s;
    snprintf(name, sizeof(name), "figure9_%s_direct", view->name);
    enum status status = bench_render(&direct, scene, &settings, plan);
    if (status == STATUS_OK)
        status = bench_picture(direct, view->mean, plan, name);
    lk_image_free(direct);
    snprintf(name, sizeof(name), "figure9_%s_all", view->name);
    if (status == STATUS_OK)
        status = bench_picture(reference, view->mean, plan, name);
    return status;
}

enum status bench_view_measure(struct bench_view *view, struct lk_scene *scene,
                               const struct bench_plan *plan)
{
    struct lk_image *reference = NULL;
    struct lk_settings settings = bench_settings(plan, plan->sizes[0], view->camera);
    settings.quantity = LK_IRRADIANCE;
    settings.depth = thesis_depths[1];
    enum status status = make_reference(&reference, view, scene, &settings, plan);
    if (status == STATUS_OK)
        view->mean = bench_mean(reference);
    if (status == STATUS_OK)
        status = draw_references(scene, &settings, reference, view, plan);

    for (int n = 0; n < 2 && view->has_curves && status == STATUS_OK; n++) {
        struct blend blend = {0};
        struct lk_image *last = NULL;
        char name[160];
        settings.shadow_rays = thesis_shadow_rays[n];
        status = measure_curve(&view->curves[n], &blend, scene, &settings, reference, plan);
        if (status == STATUS_OK)
            status = (enum status)lk_image_create(&last, blend.mean, blend.width, blend.height);
        snprintf(name, sizeof(name), "figure10_%s_%u", view->name, thesis_shadow_rays[n]);
        if (status == STATUS_OK)
            status = bench_picture(last, view->mean, plan, name);
        lk_image_free(last);
        blend_free(&blend);
    }
    lk_image_free(reference);
    return status;
}

double bench_curve_reach(const struct bench_curve *curve, double variance, bool rays)
{
    for (unsigned i = 0; i < curve->count; i++) {
        const struct bench_point *b = &curve->points[i];
        const double at_b = rays ? b->rays : b->time_s;
        if (b->variance > variance)
            continue;
        if (i == 0)
            return at_b;
        // A straight line between two points of the double-logarithmic plot.
        const struct bench_point *a = &curve->points[i - 1];
        const double at_a = rays ? a->rays : a->time_s;
        const double t = log(a->variance / variance) / log(a->variance / b->variance);
        return at_a * pow(at_b / at_a, t);
    }
    return INFINITY;
}
