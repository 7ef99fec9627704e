/**
 * @file
 * How long a tracer takes for a ray of each class (cli/bench_rays.h).
 */
#ifndef CLI_BENCH_RATES_H
#define CLI_BENCH_RATES_H

#include "cli/bench_rays.h"

#define RATE_RUNS_MAX 1000u

/** One tracer's times. All zero: none. */
struct ray_rates {
    struct lk_tracer *tracer; // owned
    struct {
        double ray_s[RATE_RUNS_MAX]; // [run_count] of one ray
        uint32_t launches;           // of a run
    } classes[RAY_CLASSES];
    uint32_t run_count;
};

/** Launches that make a run long enough to be measured, if one takes so many seconds. */
uint32_t ray_launches(double seconds);

/** Warms the tracer up with all classes that have rays. @retval  As lk_tracer_run(). */
enum status ray_rates_warm_up(struct ray_rates *rates, const struct ray_set *sets);

/** Measures one more run of each class that has rays. @retval  As lk_tracer_run(). */
enum status ray_rates_run(struct ray_rates *rates, const struct ray_set *sets);

/** The median of a class's runs, seconds a ray; 0 if it has none. Puts the runs in order. */
double ray_rates_median(struct ray_rates *rates, enum ray_class class);

void ray_rates_free(struct ray_rates *rates);

#endif
