#include <stdio.h>
#include <stdlib.h>

#include "cli/bench.h"
#include "cli/bench_oracle.h"
#include "cli/bench_rates.h"
#include "cli/bench_rays.h"
#include "cli/progress.h"
#include "core/json.h"

#define RUNS_MAX 1000

#define VISITS_SAMPLE 16384u // rays whose visits are counted, of each class

// One way to trace.
struct variant {
    const char *name;
    enum lk_bvh_build build;
    enum lk_bvh bvh;
    enum lk_trace trace;
    enum lk_nodes nodes;
};

// The thesis's comes first.
static const struct variant variants[] = {
    {"thesis: binary persistent", LK_BVH_BUILD_THESIS, LK_BVH_BINARY, LK_TRACE_PERSISTENT,
     LK_NODES_BUFFER},
    {"thesis: as texture", LK_BVH_BUILD_THESIS, LK_BVH_BINARY, LK_TRACE_PERSISTENT,
     LK_NODES_TEXTURE},
    {"thesis BVH, wide simple", LK_BVH_BUILD_THESIS, LK_BVH_WIDE, LK_TRACE_SIMPLE, LK_NODES_BUFFER},
    {"binary simple", LK_BVH_BUILD_SBVH, LK_BVH_BINARY, LK_TRACE_SIMPLE, LK_NODES_BUFFER},
    {"binary persistent", LK_BVH_BUILD_SBVH, LK_BVH_BINARY, LK_TRACE_PERSISTENT, LK_NODES_BUFFER},
    {"binary postponing", LK_BVH_BUILD_SBVH, LK_BVH_BINARY, LK_TRACE_POSTPONING, LK_NODES_BUFFER},
    {"binary warps", LK_BVH_BUILD_SBVH, LK_BVH_BINARY, LK_TRACE_WARPS, LK_NODES_BUFFER},
    {"quad simple", LK_BVH_BUILD_SBVH, LK_BVH_QUAD, LK_TRACE_SIMPLE, LK_NODES_BUFFER},
    {"quad postponing", LK_BVH_BUILD_SBVH, LK_BVH_QUAD, LK_TRACE_POSTPONING, LK_NODES_BUFFER},
    {"quad warps", LK_BVH_BUILD_SBVH, LK_BVH_QUAD, LK_TRACE_WARPS, LK_NODES_BUFFER},
    {"compressed simple", LK_BVH_BUILD_SBVH, LK_BVH_COMPRESSED, LK_TRACE_SIMPLE, LK_NODES_BUFFER},
    {"compressed postponing", LK_BVH_BUILD_SBVH, LK_BVH_COMPRESSED, LK_TRACE_POSTPONING,
     LK_NODES_BUFFER},
    {"compressed warps", LK_BVH_BUILD_SBVH, LK_BVH_COMPRESSED, LK_TRACE_WARPS, LK_NODES_BUFFER},
    {"wide simple", LK_BVH_BUILD_SBVH, LK_BVH_WIDE, LK_TRACE_SIMPLE, LK_NODES_BUFFER},
    {"wide persistent", LK_BVH_BUILD_SBVH, LK_BVH_WIDE, LK_TRACE_PERSISTENT, LK_NODES_BUFFER},
};

#define VARIANT_COUNT (sizeof(variants) / sizeof(variants[0]))

// What one variant did with one class of rays.
struct cell {
    double seconds[RUNS_MAX]; // [runs] of one launch, then in ascending order
    uint32_t launches;        // of a run
    uint32_t wrong;           // hits of the sample that cannot be right
};

struct row {
    const struct variant *variant;
    struct lk_tracer *tracer; // owned; NULL: the device does not take this variant
    struct cell cells[RAY_CLASSES];
};

struct bench {
    const struct options *options;
    struct lk_scene *scene; // owned
    struct row *rows;       // [VARIANT_COUNT]; owned
    struct ray_set sets[RAY_CLASSES];
    struct oracle oracles[RAY_CLASSES];
    struct lk_visits visits[RAY_CLASSES]; // of the default BVH, by a sample of the rays
    struct lk_geometry geometry;
};

static enum status create_tracers(struct bench *b)
{
    for (size_t i = 0; i < VARIANT_COUNT; i++) {
        struct lk_settings settings = b->options->settings;
        struct row *row = &b->rows[i];
        row->variant = &variants[i];
        settings.bvh_build = row->variant->build;
        settings.bvh = row->variant->bvh;
        settings.trace = row->variant->trace;
        settings.nodes = row->variant->nodes;
        const enum lk_status status = lk_tracer_create(&row->tracer, b->scene, &settings);
        if (status != LK_OK && (i == 0 || (status != LK_LIMIT && status != LK_UNSUPPORTED)))
            return (enum status)status;
    }
    return STATUS_OK;
}

// Warms a variant up, checks its hits, and finds how often a run launches it.
static enum status warm_up(struct row *row, enum ray_class class, const struct bench *b,
                           struct lk_hit *hits)
{
    const struct ray_set *set = &b->sets[class];
    struct cell *cell = &row->cells[class];
    double seconds = 0.0;
    enum lk_status status = lk_tracer_set_rays(row->tracer, set->rays, set->count);
    for (int i = 0; i < 2 && status == LK_OK; i++) // the first may wait for a compiler
        status = lk_tracer_run(row->tracer, &seconds, set->any_hit, 1);
    if (status == LK_OK)
        status = lk_tracer_hits(row->tracer, hits);
    if (status != LK_OK)
        return (enum status)status;
    cell->wrong = oracle_count_wrong(&b->oracles[class], set, hits);
    cell->launches = ray_launches(seconds);
    return STATUS_OK;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

// Measures all variants with one class of rays, in turns, so that what else the machine does meets
// all of them.
static enum status measure_class(struct bench *b, enum ray_class class, struct lk_hit *hits)
{
    const uint32_t runs = b->options->runs;
    enum status status = oracle_build(&b->oracles[class], &b->geometry, &b->sets[class]);
    for (size_t i = 0; i < VARIANT_COUNT && status == STATUS_OK; i++)
        if (b->rows[i].tracer != NULL)
            status = warm_up(&b->rows[i], class, b, hits);
    for (uint32_t run = 0; run < runs && status == STATUS_OK; run++) {
        for (size_t i = 0; i < VARIANT_COUNT && status == STATUS_OK; i++) {
            struct row *row = &b->rows[i];
            struct cell *cell = &row->cells[class];
            if (row->tracer != NULL)
                status = (enum status)lk_tracer_run(row->tracer, &cell->seconds[run],
                                                    b->sets[class].any_hit, cell->launches);
        }
        if (progress_is_interrupted())
            status = status_fail(STATUS_CANCELLED, "interrupted");
    }
    for (size_t i = 0; i < VARIANT_COUNT && status == STATUS_OK; i++)
        qsort(b->rows[i].cells[class].seconds, runs, sizeof(double), compare_doubles);
    return status;
}

// Counts what the rays visit.
static enum status count_visits(struct bench *b)
{
    enum lk_status status = LK_OK;
    for (int i = 0; i < RAY_CLASSES && status == LK_OK; i++) {
        const struct ray_set *set = &b->sets[i];
        status = lk_scene_visits(&b->visits[i], b->scene, &b->options->settings, set->rays,
                                 set->count, 1 + set->count / VISITS_SAMPLE, set->any_hit);
    }
    return (enum status)status;
}

static enum status measure(struct bench *b)
{
    const struct lk_tracer_info *info = lk_tracer_info(b->rows[0].tracer);
    struct lk_hit *hits = malloc((size_t)info->width * info->height * sizeof(*hits));
    enum status status = STATUS_OK;
    if (hits == NULL)
        status =
            status_fail(STATUS_NO_MEMORY, "no memory for %u x %u hits", info->width, info->height);
    if (status == STATUS_OK)
        status = (enum status)lk_scene_geometry(&b->geometry, b->scene);
    if (status == STATUS_OK)
        status = ray_sets_make(b->sets, b->scene, b->rows[0].tracer, b->options->views);
    if (status == STATUS_OK)
        status = count_visits(b);
    for (int i = 0; i < RAY_CLASSES && status == STATUS_OK; i++)
        status = measure_class(b, (enum ray_class)i, hits);
    free(hits);
    return status;
}

// Million rays a second of the run at a place of the order: 0 the fastest, 1 the slowest.
static double rate(const struct bench *b, const struct cell *cell, int class, double place)
{
    const uint32_t i = (uint32_t)(place * (double)(b->options->runs - 1) + 0.5);
    return cell->seconds[i] > 0.0 ? b->sets[class].count / cell->seconds[i] * 1e-6 : 0.0;
}

static uint32_t count_wrong(const struct bench *b)
{
    uint32_t wrong = 0;
    for (size_t i = 0; i < VARIANT_COUNT; i++)
        for (int k = 0; k < RAY_CLASSES; k++)
            wrong += b->rows[i].cells[k].wrong;
    return wrong;
}

static void print_row(const struct bench *b, const struct row *row)
{
    printf("%-28s", row->variant->name);
    if (row->tracer == NULL) {
        printf(" not on this device\n");
        return;
    }
    const struct lk_tracer_info *info = lk_tracer_info(row->tracer);
    printf(" %7.2f %7.1f", info->build_s, (double)info->bvh_size * 1e-6);
    for (int k = 0; k < RAY_CLASSES; k++) {
        char range[32];
        const struct cell *cell = &row->cells[k];
        snprintf(range, sizeof(range), "(%.4g-%.4g)", rate(b, cell, k, 1.0), rate(b, cell, k, 0.0));
        printf(" %6.4g %-13s", rate(b, cell, k, 0.5), range);
    }
    printf("\n");
}

static void print_table(const struct bench *b)
{
    const struct lk_tracer_info *info = lk_tracer_info(b->rows[0].tracer);
    printf("%s, %llu triangles, %u x %u, %u view%s, %s\n", b->options->operands[1],
           (unsigned long long)b->geometry.triangle_count, info->width, info->height,
           b->options->views, b->options->views > 1 ? "s" : "", info->device.name);
    printf("Mrays/s: median of %u runs (least-most)\n", b->options->runs);
    printf("%-28s %7s %7s", "variant", "build s", "MB");
    for (int k = 0; k < RAY_CLASSES; k++)
        printf(" %-20s", ray_class_names[k]);
    printf("\n");
    for (size_t i = 0; i < VARIANT_COUNT; i++)
        print_row(b, &b->rows[i]);
    printf("%-28s %7s %7s", "rays, checked", "", "");
    for (int k = 0; k < RAY_CLASSES; k++) {
        char text[32];
        snprintf(text, sizeof(text), "%u, %u", b->sets[k].count, b->oracles[k].count);
        printf(" %-20s", text);
    }
    printf("\n%-28s %7s %7s", "binary nodes, triangles", "", "");
    for (int k = 0; k < RAY_CLASSES; k++) {
        char text[32];
        snprintf(text, sizeof(text), "%.1f, %.1f", b->visits[k].nodes, b->visits[k].triangles);
        printf(" %-20s", text);
    }
    printf("\n");
}

static void write_cell(struct json *json, const struct bench *b, const struct cell *cell, int class)
{
    json_object(json, NULL);
    json_string(json, "rays", ray_class_names[class]);
    json_uint(json, "count", b->sets[class].count);
    json_double(json, "mrays_per_s", rate(b, cell, class, 0.5));
    json_double(json, "mrays_per_s_least", rate(b, cell, class, 1.0));
    json_double(json, "mrays_per_s_most", rate(b, cell, class, 0.0));
    json_uint(json, "launches", cell->launches);
    json_uint(json, "checked", b->oracles[class].count);
    json_uint(json, "wrong", cell->wrong);
    json_object_end(json);
}

static void write_row(struct json *json, const struct bench *b, const struct row *row)
{
    json_object(json, NULL);
    json_string(json, "name", row->variant->name);
    json_bool(json, "usable", row->tracer != NULL);
    if (row->tracer != NULL) {
        const struct lk_tracer_info *info = lk_tracer_info(row->tracer);
        json_double(json, "build_s", info->build_s);
        json_uint(json, "bvh_bytes", info->bvh_size);
        json_uint(json, "references", info->references);
        json_array(json, "classes");
        for (int k = 0; k < RAY_CLASSES; k++)
            write_cell(json, b, &row->cells[k], k);
        json_array_end(json);
    }
    json_object_end(json);
}

static void write_visits(struct json *json, const struct lk_visits *visits, int class)
{
    json_object(json, NULL);
    json_string(json, "rays", ray_class_names[class]);
    json_double(json, "binary_nodes_per_ray", visits->nodes);
    json_double(json, "triangles_per_ray", visits->triangles);
    json_object_end(json);
}

static enum status print_json(const struct bench *b)
{
    const struct lk_tracer_info *info = lk_tracer_info(b->rows[0].tracer);
    struct json json = {0};
    json_object(&json, NULL);
    json_string(&json, "scene", b->options->operands[1]);
    json_string(&json, "version", lk_version());
    json_string(&json, "device", info->device.name);
    json_string(&json, "driver", info->device.driver);
    json_uint(&json, "triangles", b->geometry.triangle_count);
    json_uint(&json, "width", info->width);
    json_uint(&json, "height", info->height);
    json_uint(&json, "views", b->options->views);
    json_uint(&json, "runs", b->options->runs);
    json_array(&json, "visits");
    for (int k = 0; k < RAY_CLASSES; k++)
        write_visits(&json, &b->visits[k], k);
    json_array_end(&json);
    json_array(&json, "variants");
    for (size_t i = 0; i < VARIANT_COUNT; i++)
        write_row(&json, b, &b->rows[i]);
    json_array_end(&json);
    json_object_end(&json);
    const enum status status = json_finish(&json);
    if (status == STATUS_OK)
        fputs(json.text, stdout);
    json_free(&json);
    return status;
}

static void release(struct bench *b)
{
    for (int k = 0; k < RAY_CLASSES; k++)
        oracle_free(&b->oracles[k]);
    ray_sets_free(b->sets);
    for (size_t i = 0; b->rows != NULL && i < VARIANT_COUNT; i++)
        lk_tracer_free(b->rows[i].tracer);
    free(b->rows);
    lk_scene_free(b->scene);
}

enum status bench_trace(const struct options *options)
{
    struct bench b = {.options = options, .rows = calloc(VARIANT_COUNT, sizeof(*b.rows))};
    enum status status = STATUS_OK;
    if (b.rows == NULL)
        status = status_fail(STATUS_NO_MEMORY, "no memory for %zu variants", VARIANT_COUNT);
    if (status == STATUS_OK)
        status = (enum status)lk_scene_load(&b.scene, options->operands[1]);
    if (status == STATUS_OK)
        status = create_tracers(&b);
    if (status == STATUS_OK)
        status = measure(&b);
    if (status == STATUS_OK && options->json)
        status = print_json(&b);
    else if (status == STATUS_OK)
        print_table(&b);
    if (status == STATUS_OK && count_wrong(&b) > 0)
        status = status_fail(STATUS_DEVICE, "%u of the checked hits are wrong", count_wrong(&b));
    release(&b);
    return status;
}
