#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/bench.h"
#include "cli/bench_rates.h"
#include "cli/bench_table.h"
#include "cli/progress.h"

#define DEFAULT_TIME_S 1.0 // of a run
#define RUNS_MAX       RATE_RUNS_MAX
#define DEPTHS         2

// The ways through the pipeline, the thesis's first: early split clipping's tree without splits, a
// queue for persistent kernels, random numbers, its light tree. A scene is loaded for each, since
// it is prepared for one.
enum way { WAY_THESIS, WAY_OURS, WAYS };

static const char *const way_names[WAYS] = {"thesis", "default"};

// Where a way's rays are traced alone: rays like those of its paths, as bench trace has them. A
// path's rays need so long by themselves:
//
//   camera rays x primary + indirect rays x the mean of the bounces' + shadow rays x shadow
struct alone {
    struct lk_scene *scenes[WAYS];      // owned; the pipeline's as well
    struct ray_rates *rates;            // [WAYS]; owned
    struct ray_set sets[RAY_CLASSES];   // of all ways; owned
    double median_s[WAYS][RAY_CLASSES]; // of one ray; 0 where there is none
};

// One way at one depth.
struct rate {
    enum way way;
    struct lk_settings settings;
    struct lk_render_info info;      // of the last run; its kernels of one with events, which has
                                     // stages apart that others may have in one
    double paths_per_s[RUNS_MAX];    // [runs], then in ascending order
    double rays_per_path;            // all kinds
    double alone_s;                  // that the rays of a path need by themselves
    double total_kernel_s, traced_s; // of all stages, and of those that trace; each by itself
};

static const struct bench_column columns[] = {
    {"depth", "depth", "%.0f"},
    {"way", "way", NULL},
    {"mpaths_per_s", "Mpaths/s", "%.4g"},
    {"mpaths_per_s_least", "least", "%.4g"},
    {"mpaths_per_s_most", "most", "%.4g"},
    {"mrays_per_s", "Mrays/s", "%.4g"},
    {"rays_per_path", "rays a path", "%.2f"},
    {"traced_percent", "tracing, %", "%.1f"},
    {"trace_only_percent", "rays alone, %", "%.1f"},
    {"kernels", "share of each kernel, %", NULL},
};

static const struct bench_column alone_columns[] = {
    {"way", "way", NULL},
    {"primary", "primary", "%.4g"},
    {"bounce_1", "bounce 1", "%.4g"},
    {"bounce_2", "bounce 2", "%.4g"},
    {"bounce_3", "bounce 3", "%.4g"},
    {"bounce_4", "bounce 4", "%.4g"},
    {"shadow", "shadow", "%.4g"},
};
_Static_assert(sizeof(alone_columns) / sizeof(alone_columns[0]) == RAY_CLASSES + 1, "a class each");

static struct lk_settings settings_of(enum way way, const struct lk_settings *asked, uint32_t depth)
{
    struct lk_settings settings = *asked;
    settings.depth = depth;
    settings.spp = 0;
    if (way == WAY_THESIS) {
        settings.bvh_build = LK_BVH_BUILD_THESIS;
        settings.bvh = LK_BVH_BINARY;
        settings.trace = LK_TRACE_PERSISTENT;
        settings.sampler = LK_SAMPLER_RANDOM;
        settings.light_sampler = LK_LIGHTS_TREE;
    }
    return settings;
}

static enum status render(struct lk_render_info *info, struct lk_scene *scene,
                          const struct lk_settings *settings)
{
    struct lk_image *image = NULL;
    const enum status status = (enum status)lk_render(&image, scene, settings, NULL);
    if (status == STATUS_OK)
        *info = *lk_image_info(image);
    lk_image_free(image);
    return status != STATUS_OK         ? status
           : progress_is_interrupted() ? status_fail(STATUS_CANCELLED, "interrupted")
                                       : STATUS_OK;
}

static bool traces(const char *kernel)
{
    return strcmp(kernel, "trace") == 0 || strcmp(kernel, "direct") == 0 ||
           strcmp(kernel, "directional") == 0;
}

// Warms up, twice in each way, since PoCL compiles a kernel once more for its first large launch:
// without events, and with them, which has stages apart. The last one counts.
static enum status warm_up(struct rate *rate, struct lk_scene *scene)
{
    struct lk_settings settings = rate->settings;
    enum status status = STATUS_OK;
    for (int i = 0; i < 4 && status == STATUS_OK; i++) {
        settings.profile = i >= 2;
        status = render(&rate->info, scene, &settings);
    }
    for (uint32_t i = 0; i < rate->info.kernel_count; i++) {
        const struct lk_kernel_time *kernel = &rate->info.kernels[i];
        rate->total_kernel_s += kernel->time_s;
        rate->traced_s += traces(kernel->name) ? kernel->time_s : 0.0;
    }
    rate->rays_per_path =
        (double)(rate->info.rays_camera + rate->info.rays_indirect + rate->info.rays_shadow) /
        (double)rate->info.paths;
    return status;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

// Loads the scene for each way and makes the rays that are traced alone.
static enum status alone_begin(struct alone *out, const struct lk_settings *asked, const char *file)
{
    enum status status = STATUS_OK;
    out->rates = calloc(WAYS, sizeof(*out->rates));
    if (out->rates == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for the rates of rays");
    for (int way = 0; way < WAYS && status == STATUS_OK; way++) {
        const struct lk_settings settings = settings_of((enum way)way, asked, 1);
        status = (enum status)lk_scene_load(&out->scenes[way], file);
        if (status == STATUS_OK)
            status =
                (enum status)lk_tracer_create(&out->rates[way].tracer, out->scenes[way], &settings);
    }
    if (status == STATUS_OK)
        status = ray_sets_make(out->sets, out->scenes[0], out->rates[0].tracer, 1);
    for (int way = 0; way < WAYS && status == STATUS_OK; way++)
        status = ray_rates_warm_up(&out->rates[way], out->sets);
    return status;
}

static void alone_free(struct alone *alone)
{
    ray_sets_free(alone->sets);
    for (int way = 0; way < WAYS; way++) {
        if (alone->rates != NULL)
            ray_rates_free(&alone->rates[way]);
        lk_scene_free(alone->scenes[way]);
    }
    free(alone->rates);
}

// The mean over the bounces whose rays there are, at most `last`, seconds a ray.
static double mean_bounce_s(const double *median_s, uint32_t last)
{
    double sum_s = 0.0;
    uint32_t count = 0;
    for (uint32_t k = RAYS_BOUNCE_1; k <= RAYS_BOUNCE_4 && k < RAYS_BOUNCE_1 + last; k++) {
        sum_s += median_s[k];
        count += median_s[k] > 0.0;
    }
    return count > 0 ? sum_s / count : 0.0;
}

// How long the rays of a path need by themselves.
static double alone_seconds(const double *median_s, const struct lk_render_info *info)
{
    const uint32_t bounces = info->settings.depth > 1 ? info->settings.depth - 1 : 1;
    return ((double)info->rays_camera * median_s[RAYS_PRIMARY] +
            (double)info->rays_indirect * mean_bounce_s(median_s, bounces) +
            (double)info->rays_shadow * median_s[RAYS_SHADOW]) /
           (double)info->paths;
}

// One run of each rate and of each way's rays.
static enum status measure_once(struct rate *rates, size_t count, struct alone *alone, uint32_t run)
{
    enum status status = STATUS_OK;
    for (size_t i = 0; i < count && status == STATUS_OK; i++) {
        struct lk_render_info info;
        status = render(&info, alone->scenes[rates[i].way], &rates[i].settings);
        if (status == STATUS_OK)
            rates[i].paths_per_s[run] = (double)info.paths / info.time_s.render;
    }
    for (int way = 0; way < WAYS && status == STATUS_OK; way++)
        status = ray_rates_run(&alone->rates[way], alone->sets);
    return status;
}

// Measures all in turns, so that what else the machine does meets all of them.
static enum status measure(struct rate *rates, size_t count, struct alone *alone, uint32_t runs)
{
    enum status status = STATUS_OK;
    for (size_t i = 0; i < count && status == STATUS_OK; i++)
        status = warm_up(&rates[i], alone->scenes[rates[i].way]);
    for (uint32_t run = 0; run < runs && status == STATUS_OK; run++)
        status = measure_once(rates, count, alone, run);
    for (int way = 0; way < WAYS; way++)
        for (int k = 0; k < RAY_CLASSES; k++)
            alone->median_s[way][k] = ray_rates_median(&alone->rates[way], (enum ray_class)k);
    for (size_t i = 0; i < count && status == STATUS_OK; i++) {
        qsort(rates[i].paths_per_s, runs, sizeof(double), compare_doubles);
        rates[i].alone_s = alone_seconds(alone->median_s[rates[i].way], &rates[i].info);
    }
    return status;
}

// "trace 55, direct 30, ...", as far as there is room.
static void write_shares(char *out, size_t size, const struct rate *rate)
{
    size_t used = 0;
    out[0] = '\0';
    for (uint32_t i = 0; i < rate->info.kernel_count && used < size; i++) {
        const struct lk_kernel_time *kernel = &rate->info.kernels[i];
        const double share = 100.0 * kernel->time_s / rate->total_kernel_s;
        if (share >= 0.5)
            used += (size_t)snprintf(out + used, size - used, "%s%s %.0f", used > 0 ? ", " : "",
                                     kernel->name, share);
    }
}

static void fill(struct bench_table *out, const struct rate *rates, size_t count, uint32_t runs)
{
    for (size_t i = 0; i < count; i++) {
        const struct rate *rate = &rates[i];
        const double median = rate->paths_per_s[runs / 2];
        char shares[sizeof(((struct bench_cell *)0)->text)];
        write_shares(shares, sizeof(shares), rate);
        bench_number(out, rate->settings.depth);
        bench_text(out, way_names[rate->way]);
        bench_number(out, median * 1e-6);
        bench_number(out, rate->paths_per_s[0] * 1e-6);
        bench_number(out, rate->paths_per_s[runs - 1] * 1e-6);
        bench_number(out, median * rate->rays_per_path * 1e-6);
        bench_number(out, rate->rays_per_path);
        bench_number(out, 100.0 * rate->traced_s / rate->total_kernel_s);
        bench_number(out, 100.0 * rate->alone_s * median);
        bench_text(out, shares);
    }
}

// Million rays a second of each way and class; none where there are no rays.
static void fill_alone(struct bench_table *out, const struct alone *alone)
{
    for (int way = 0; way < WAYS; way++) {
        bench_text(out, way_names[way]);
        for (int k = 0; k < RAY_CLASSES; k++)
            bench_number(out, 1e-6 / alone->median_s[way][k]);
    }
}

static enum status print(const struct rate *rates, size_t count, const struct alone *alone,
                         const struct options *options)
{
    const struct lk_render_info *info = &rates[0].info;
    struct bench_table table = {.key = "paths",
                                .title = "Paths a second of the whole pipeline",
                                .columns = columns,
                                .column_count = sizeof(columns) / sizeof(columns[0])};
    struct bench_table rays = {.key = "rays_alone_mrays_per_s",
                               .title = "Rays like theirs, traced alone, Mrays/s",
                               .columns = alone_columns,
                               .column_count = RAY_CLASSES + 1};
    enum status status = STATUS_OK;
    fill(&table, rates, count, options->runs);
    fill_alone(&rays, alone);
    if (options->json) {
        struct json json = {0};
        bench_json_begin(&json, "path", &info->device);
        json_string(&json, "scene", options->operands[1]);
        json_uint(&json, "width", info->settings.width);
        json_uint(&json, "height", info->settings.height);
        json_uint(&json, "shadow_rays", info->settings.shadow_rays);
        json_uint(&json, "runs", options->runs);
        bench_table_json(&json, &table);
        bench_table_json(&json, &rays);
        json_object_end(&json);
        status = json_print(&json);
    } else {
        printf("%s, %u x %u, %u shadow rays a hit, median of %u runs, %s\n", options->operands[1],
               info->settings.width, info->settings.height, info->settings.shadow_rays,
               options->runs, info->device.name);
        bench_table_print(stdout, &table);
        bench_table_print(stdout, &rays);
    }
    bench_table_free(&rays);
    bench_table_free(&table);
    return status;
}

enum status bench_pipeline(const struct options *options)
{
    static const uint32_t depths[DEPTHS] = {1, 5};
    struct options defaults;
    options_init(&defaults);
    const bool one_depth = options->settings.depth != defaults.settings.depth;
    struct lk_settings asked = options->settings;
    if (!(asked.time_s > 0.0))
        asked.time_s = DEFAULT_TIME_S;

    struct alone alone = {0};
    struct rate *rates = calloc((size_t)WAYS * DEPTHS, sizeof(*rates));
    size_t count = 0;
    enum status status = STATUS_OK;
    if (rates == NULL)
        status = status_fail(STATUS_NO_MEMORY, "no memory for the rates");
    for (int depth = 0; depth < (one_depth ? 1 : DEPTHS) && status == STATUS_OK; depth++)
        for (int way = 0; way < WAYS; way++, count++) {
            rates[count].way = (enum way)way;
            rates[count].settings =
                settings_of((enum way)way, &asked, one_depth ? asked.depth : depths[depth]);
        }
    if (status == STATUS_OK)
        status = alone_begin(&alone, &asked, options->operands[1]);
    if (status == STATUS_OK)
        status = measure(rates, count, &alone, options->runs);
    if (status == STATUS_OK)
        status = print(rates, count, &alone, options);
    alone_free(&alone);
    free(rates);
    return status;
}
