/**
 * @file
 * What `lightkiln bench report` finds out, and the functions that find it out.
 */
#ifndef CLI_BENCH_RESULTS_H
#define CLI_BENCH_RESULTS_H

#include "cli/bench_table.h"
#include "cli/bench_thesis.h"
#include "cli/options.h"

#define BENCH_SCENES_MAX   (OPERANDS_MAX - 1)
#define BENCH_VIEWS_MAX    2
#define BENCH_POINTS_MAX   32
#define BENCH_PICTURES_MAX 8

/** How much is done. */
struct bench_plan {
    const struct options *options;
    const char *folder;                                   // for everything that is written
    uint32_t sizes[2];                                    // pixels along a side; Table 2
    double measure_s, converge_s, reference_s, picture_s; // seconds of one render
};

/** One cell of Tables 2 and 3. */
struct bench_speed {
    double rays_per_s, spp, render_s;
    double traversal, lighting, others; // shares of the kernels' time, 0 .. 1
};

struct bench_point {
    double time_s, rays, spp, variance;
};

/** Variance as samples come in. */
struct bench_curve {
    struct bench_point points[BENCH_POINTS_MAX];
    unsigned count;
};

struct bench_view {
    char camera[64];
    char name[64];                // in file names: scene, or scene and camera
    char title[64];               // what the thesis calls it, or the scene's name
    struct bench_curve curves[2]; // of thesis_shadow_rays
    double reference_spp, reference_s;
    double mean;       // of the reference's channels, lux
    bool has_curves;   // not without lights to draw from
    int thesis_faster; // Figure 7: 1 if 4 shadow rays are faster in time, -1 if slower, 0: not told
    int thesis_better; // Figure 8: the same by rays
};

struct bench_scene {
    char name[64];
    const char *file;                  // borrowed
    const struct thesis_scene *thesis; // NULL: none
    struct lk_scene_info info[2];      // with plan sizes, but at 512 and 1024
    struct lk_device_info device;
    struct lk_memory used;             // by the largest of the timed renders
    uint32_t queue;                    // of those
    uint32_t small_queue;              // whose per-ray data are half of the thesis's, or less
    double small_rays_per_s;           // with it: larger size, depth 5, 1 shadow ray
    struct bench_speed speed[2][2][2]; // [size][depth][shadow rays]
    struct bench_view views[BENCH_VIEWS_MAX];
    unsigned view_count;
    char pictures[BENCH_PICTURES_MAX][64]; // cameras of Figure 11
    unsigned picture_count;
};

struct bench_results {
    struct bench_plan plan;
    struct bench_scene scenes[BENCH_SCENES_MAX];
    unsigned scene_count;
};

/** What the options ask for. */
struct bench_plan bench_plan_of(const struct options *options);

/** Is the scene there? @retval STATUS_IO  Tells how the scenes of these experiments are made. */
enum status bench_find_scene(const char *file);

/** The thesis's settings: its light tree; what else the options say. */
struct lk_settings bench_settings(const struct bench_plan *plan, uint32_t size, const char *camera);

/** Renders with a progress line. An interrupt is STATUS_CANCELLED, and leaves no image. */
enum status bench_render(struct lk_image **out, struct lk_scene *scene,
                         const struct lk_settings *settings, const struct bench_plan *plan);

/** All of one scene: Tables 1 to 3, curves, pictures. `file` and `out` must be there to the end. */
enum status bench_scene_measure(struct bench_scene *out, const char *file,
                                const struct bench_plan *plan);

/** Figures 7 to 10 of one view: reference, curves, pictures. */
enum status bench_view_measure(struct bench_view *view, struct lk_scene *scene,
                               const struct bench_plan *plan);

/** Writes an experiment of one table: EXPERIMENT.json, .csv and .md, and prints it. */
enum status bench_deliver(const struct bench_table *table, const struct lk_device_info *device,
                          const struct options *options, const char *experiment);

/** Writes FOLDER/NAME.jpg so that a mean value comes out at a middle grey. */
enum status bench_picture(const struct lk_image *image, double mean, const struct bench_plan *plan,
                          const char *name);

/** The mean over all channels. */
double bench_mean(const struct lk_image *image);

/** The time, or the rays, that a curve takes to a variance; infinite if it never gets there. */
double bench_curve_reach(const struct bench_curve *curve, double variance, bool rays);

/** Bytes of a path in flight. */
double bench_path_size(const struct bench_scene *scene);

/** Bytes on the device at 1024 x 1024, with so many paths in flight. */
uint64_t bench_total_memory(const struct bench_scene *scene, uint32_t queue);

/** Figure 6: what a shadow ray costs, in camera and indirect rays; indices of thesis_depths and
 * thesis_shadow_rays. */
double bench_shadow_cost(const struct bench_scene *scene, int depth, int shadow);

/** The thesis's conclusions one by one. The table is to be freed. */
void bench_conclusions(struct bench_table *out, const struct bench_results *results);

#endif
