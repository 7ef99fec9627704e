// What section 4.2 of the thesis concludes, against what was measured here.

#include <math.h>
#include <stdarg.h>

#include "cli/bench_results.h"

#define SAME       0.05 // speeds that differ by less are called equal: runs of one kind do
#define MEGABYTE   1e6
#define DEFAULT_AT 1 // index of 1024 x 1024 in bench_scene.info

static const struct bench_column columns[] = {
    {"conclusion", "conclusion of the thesis", NULL},
    {"holds", "today", NULL},
    {"measured", "measured here", NULL},
    {"thesis", "measured there", NULL},
};

// Least and most of something.
struct range {
    double low, high;
    unsigned count;
};

static void widen(struct range *range, double value)
{
    if (!isfinite(value))
        return;
    range->low = range->count == 0 || value < range->low ? value : range->low;
    range->high = range->count == 0 || value > range->high ? value : range->high;
    range->count++;
}

#ifdef __GNUC__
__attribute__((format(printf, 5, 6)))
#endif
static void
add(struct bench_table *out, const char *conclusion, const char *holds, const char *thesis,
    const char *format, ...)
{
    char text[96];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof(text), format, arguments);
    va_end(arguments);
    bench_text(out, conclusion);
    bench_text(out, holds);
    bench_text(out, text);
    bench_text(out, thesis);
}

static const char *verdict(bool known, bool holds)
{
    return !known ? "not measured" : holds ? "holds" : "does not hold";
}

// Does a range lie above 1, across it or below?
static const char *verdict_above(const struct range *range)
{
    if (range->count == 0)
        return "not measured";
    if (range->low >= 1.0)
        return "holds";
    return range->high > 1.0 ? "holds in part" : "does not hold";
}

// ---- Section 4.2.1

double bench_path_size(const struct bench_scene *scene)
{
    return (double)scene->used.rays / scene->queue;
}

uint64_t bench_total_memory(const struct bench_scene *scene, uint32_t queue)
{
    const struct lk_memory *used = &scene->used;
    const struct lk_memory *frame = &scene->info[DEFAULT_AT].memory;
    return used->bvh + used->geometry + used->materials + used->lights + frame->samples +
           (uint64_t)(bench_path_size(scene) * queue) + frame->film;
}

static void conclude_memory(struct bench_table *out, const struct bench_results *results)
{
    struct range geometry = {0};
    struct range bvh = {0};
    struct range share = {0};
    struct range rays = {0};
    struct range quarter = {0};
    struct range dominant = {0};
    struct range pixels = {0};
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct lk_scene_info *info = &results->scenes[i].info[DEFAULT_AT];
        const double triangles = (double)info->triangles;
        const struct lk_memory *used = &results->scenes[i].used;
        widen(&geometry, (double)used->geometry / triangles);
        widen(&bvh, (double)used->bvh / triangles);
        widen(&share, (double)used->bvh / (double)used->geometry);
        widen(&dominant, (double)used->rays / fmax(fmax((double)used->bvh, (double)used->geometry),
                                                   (double)used->materials));
        widen(&rays, (double)info->memory.rays / MEGABYTE);
        widen(&pixels, bench_path_size(&results->scenes[i]) * THESIS_PIXELS / MEGABYTE);
        widen(&quarter, (double)info->memory.rays / (double)results->scenes[i].info[0].memory.rays);
    }
    add(out, "geometry grows linearly with the triangles",
        verdict(geometry.count > 1, geometry.high < 1.25 * geometry.low),
        "145 to 174 bytes a triangle", "%.0f to %.0f bytes a triangle, by how many share a corner",
        geometry.low, geometry.high);
    add(out, "the BVH grows linearly, too", verdict(bvh.count > 1, bvh.high < 1.25 * bvh.low),
        "14 to 15 bytes a triangle", "%.0f to %.0f bytes a triangle", bvh.low, bvh.high);
    add(out, "the BVH is small beside the geometry", verdict(share.count > 0, share.high < 0.5),
        "8 to 10 %, Woop's rows with the geometry", "%.0f to %.0f %%, Woop's rows with the BVH",
        100.0 * share.low, 100.0 * share.high);
    add(out, "per-ray data do not depend on the scene",
        verdict(rays.count > 1, rays.high == rays.low), "188 MB at 1024 x 1024",
        "%.0f to %.0f MB at 1024 x 1024", rays.low, rays.high);
    add(out, "a path for each of 1024 x 1024 pixels takes at most half of the thesis's data (ours)",
        verdict(pixels.count > 0, pixels.high <= 0.5 * THESIS_RAYS_MB), "188 MB", "%.0f MB",
        pixels.high);
    add(out, "for some scenes per-ray data are the dominant part",
        verdict(dominant.count > 0, dominant.high > 1.0), "0.72 to 32 times the largest other",
        "%.2g to %.2g times the largest other", dominant.low, dominant.high);
    add(out, "per-ray data grow with the frame: 1024 x 1024 takes 4 times 512 x 512",
        verdict(quarter.count > 0, fabs(quarter.low - 4.0) < 0.1 && quarter.high < 4.1), "4 times",
        "%.2f times", quarter.high);
}

static void conclude_limits(struct bench_table *out, const struct bench_results *results)
{
    struct range rays = {0};
    struct range speed = {0};
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct bench_scene *scene = &results->scenes[i];
        widen(&rays, bench_path_size(scene) * scene->small_queue / MEGABYTE);
        widen(&speed, 100.0 * scene->small_rays_per_s / scene->speed[1][1][0].rays_per_s);
        if (scene->thesis == NULL || scene->thesis->triangles < 1e6)
            continue;
        const double total = (double)bench_total_memory(scene, scene->small_queue) / MEGABYTE;
        add(out, "a whole game level fits: the deck at 1024 x 1024 takes no more than DMDeck",
            verdict(true, total <= scene->thesis->footprint_mb), "528 MB",
            "%.0f MB, %u paths in flight", total, scene->small_queue);
    }
    add(out, "half of the thesis's per-ray data is enough for 90 % of the speed (ours)",
        verdict(rays.count > 0, rays.high <= 0.5 * THESIS_RAYS_MB && speed.low > 90.0), "188 MB",
        "%.0f MB for %.0f to %.0f %% of the speed with the default", rays.high, speed.low,
        speed.high);
}

// ---- Section 4.2.2: speed

static double speed(const struct bench_scene *scene, int size, int depth, int shadow)
{
    return scene->speed[size][depth][shadow].rays_per_s;
}

static void conclude_speed(struct bench_table *out, const struct bench_results *results)
{
    struct range size = {0};
    struct range depth = {0};
    struct range shadow = {0};
    struct range without = {0}; // lights in the tree
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct bench_scene *scene = &results->scenes[i];
        for (int k = 0; k < 4; k++) {
            const int a = k & 1;
            const int b = k >> 1;
            widen(&size, speed(scene, 1, a, b) / speed(scene, 0, a, b));
            widen(&depth, speed(scene, a, 0, b) / speed(scene, a, 1, b));
            widen(scene->info[0].lights.drawn > 0 ? &shadow : &without,
                  speed(scene, a, b, 1) / speed(scene, a, b, 0));
        }
    }
    add(out, "a larger image is faster, ray by ray", verdict_above(&size), "1.19 to 1.53 times",
        "%.2f to %.2f times", size.low, size.high);
    add(out, "depth 1 is faster than depth 5", verdict_above(&depth), "1.43 to 2.07 times",
        "%.2f to %.2f times", depth.low, depth.high);
    add(out, "4 shadow rays give more rays a second than 1", verdict_above(&shadow),
        "1.20 to 1.91 times", "%.2f to %.2f times", shadow.low, shadow.high);
    add(out, "without lights in the tree their number changes nothing",
        verdict(without.count > 0, without.low > 1.0 - SAME && without.high < 1.0 + SAME),
        "0.96 to 1.00 times", "%.2f to %.2f times", without.low, without.high);
}

double bench_shadow_cost(const struct bench_scene *scene, int depth, int shadow)
{
    const struct bench_speed *speed = &scene->speed[1][depth][shadow];
    return speed->lighting / speed->traversal / thesis_shadow_rays[shadow];
}

static void conclude_shadow_rays(struct bench_table *out, const struct bench_results *results)
{
    struct range cost = {0};
    struct range deeper = {0};
    struct range more = {0};
    for (unsigned i = 0; i < results->scene_count; i++) {
        const struct bench_scene *scene = &results->scenes[i];
        if (scene->info[0].lights.drawn == 0)
            continue;
        for (int a = 0; a < 2; a++) {
            for (int b = 0; b < 2; b++)
                widen(&cost, 1.0 / bench_shadow_cost(scene, a, b));
            widen(&deeper, bench_shadow_cost(scene, 0, a) / bench_shadow_cost(scene, 1, a));
            widen(&more, bench_shadow_cost(scene, a, 0) / bench_shadow_cost(scene, a, 1));
        }
    }
    add(out, "a shadow ray is cheaper than a camera or indirect ray", verdict_above(&cost),
        "0.40 to 1.76 of one", "%.2f to %.2f of one", 1.0 / cost.high, 1.0 / cost.low);
    add(out, "its relative cost falls with depth", verdict_above(&deeper), "1.14 to 2.73 times",
        "%.2f to %.2f times", deeper.low, deeper.high);
    add(out, "it falls with more shadow rays", verdict_above(&more), "1.16 to 1.35 times",
        "%.2f to %.2f times", more.low, more.high);
}

// ---- Section 4.2.2: convergence

// How many times less time, or rays, the second curve takes to the variance that both reach.
static double advantage(const struct bench_view *view, bool rays)
{
    const struct bench_curve *one = &view->curves[0];
    const struct bench_curve *four = &view->curves[1];
    if (!view->has_curves || one->count == 0 || four->count == 0)
        return NAN;
    const double last = one->points[one->count - 1].variance;
    const double other = four->points[four->count - 1].variance;
    const double variance = last > other ? last : other;
    return bench_curve_reach(one, variance, rays) / bench_curve_reach(four, variance, rays);
}

static void conclude_convergence(struct bench_table *out, const struct bench_results *results)
{
    for (unsigned i = 0; i < results->scene_count; i++) {
        for (unsigned v = 0; v < results->scenes[i].view_count; v++) {
            const struct bench_view *view = &results->scenes[i].views[v];
            for (int by_rays = 0; by_rays < 2; by_rays++) {
                const int thesis = by_rays ? view->thesis_better : view->thesis_faster;
                const double gain = advantage(view, by_rays);
                char text[96];
                if (thesis == 0)
                    continue;
                snprintf(text, sizeof(text), "%s: 4 shadow rays %s %s than 1", view->title,
                         by_rays ? "need" : "converge",
                         by_rays ? (thesis > 0 ? "fewer rays" : "more rays")
                                 : (thesis > 0 ? "faster in time" : "slower in time"));
                add(out, text, verdict(isfinite(gain), thesis > 0 ? gain > 1.0 : gain < 1.0),
                    by_rays ? "Figure 8" : "Figure 7", "%s to the same variance: %.2f times",
                    by_rays ? "rays of 1 over those of 4" : "time of 1 over that of 4", gain);
            }
        }
    }
}

void bench_conclusions(struct bench_table *out, const struct bench_results *results)
{
    *out = (struct bench_table){.key = "conclusions",
                                .title = "The thesis's conclusions",
                                .columns = columns,
                                .column_count = sizeof(columns) / sizeof(columns[0])};
    conclude_memory(out, results);
    conclude_limits(out, results);
    conclude_speed(out, results);
    conclude_shadow_rays(out, results);
    conclude_convergence(out, results);
}
