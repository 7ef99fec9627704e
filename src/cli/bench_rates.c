#include "cli/bench_rates.h"

#include <stdlib.h>

#define RUN_SECONDS 0.02 // a run launches as often as fills that, where launches are short

uint32_t ray_launches(double seconds)
{
    const double launches = RUN_SECONDS / (seconds > 1e-6 ? seconds : 1e-6);
    return launches < 1.0 ? 1 : launches > LK_LAUNCHES_MAX ? LK_LAUNCHES_MAX : (uint32_t)launches;
}

enum status ray_rates_warm_up(struct ray_rates *rates, const struct ray_set *sets)
{
    enum lk_status status = LK_OK;
    for (int k = 0; k < RAY_CLASSES && status == LK_OK; k++) {
        double seconds = 0.0;
        if (sets[k].count > 0)
            status = lk_tracer_set_rays(rates->tracer, sets[k].rays, sets[k].count);
        for (int i = 0; i < 2 && sets[k].count > 0 && status == LK_OK; i++) // compilers
            status = lk_tracer_run(rates->tracer, &seconds, sets[k].any_hit, 1);
        rates->classes[k].launches = ray_launches(seconds);
    }
    return (enum status)status;
}

enum status ray_rates_run(struct ray_rates *rates, const struct ray_set *sets)
{
    enum lk_status status = LK_OK;
    for (int k = 0; k < RAY_CLASSES && status == LK_OK; k++) {
        double seconds = 0.0;
        if (sets[k].count > 0)
            status = lk_tracer_set_rays(rates->tracer, sets[k].rays, sets[k].count);
        if (sets[k].count > 0 && status == LK_OK)
            status =
                lk_tracer_run(rates->tracer, &seconds, sets[k].any_hit, rates->classes[k].launches);
        rates->classes[k].ray_s[rates->run_count] =
            sets[k].count > 0 ? seconds / sets[k].count : 0.0;
    }
    rates->run_count++;
    return (enum status)status;
}

static int compare_doubles(const void *a, const void *b)
{
    const double x = *(const double *)a;
    const double y = *(const double *)b;
    return (x > y) - (x < y);
}

double ray_rates_median(struct ray_rates *rates, enum ray_class class)
{
    double *ray_s = rates->classes[class].ray_s;
    if (rates->run_count == 0)
        return 0.0;
    qsort(ray_s, rates->run_count, sizeof(*ray_s), compare_doubles);
    return ray_s[rates->run_count / 2];
}

void ray_rates_free(struct ray_rates *rates)
{
    lk_tracer_free(rates->tracer);
    *rates = (struct ray_rates){0};
}
