#include "cli/bench.h"

#include <string.h>

#include "cli/commands.h"
#include "cli/progress.h"

struct experiment {
    const char *name;
    enum status (*run)(const struct options *options);
    unsigned scenes_min, scenes_max; // that may be named
};

static const struct experiment experiments[] = {
    {"report", bench_report, 0, OPERANDS_MAX - 1},
    {"lights", bench_lights, 1, 1},
    {"trace", bench_trace, 1, 1},
    {"memory", bench_memory, 0, OPERANDS_MAX - 1},
    {"scale", bench_scale, 0, 0},
};

enum status bench_refuse(const struct options *options, const char *experiment)
{
    struct options defaults;
    options_init(&defaults);
    const struct lk_settings *given = &options->settings;
    const struct lk_settings *none = &defaults.settings;
    const char *name = given->width != none->width               ? "width"
                       : given->height != none->height           ? "height"
                       : given->camera != none->camera           ? "camera"
                       : given->depth != none->depth             ? "depth"
                       : given->shadow_rays != none->shadow_rays ? "shadow-rays"
                                                                 : NULL;
    if (name == NULL)
        return STATUS_OK;
    return status_fail(STATUS_USAGE, "bench %s chooses --%s itself", experiment, name);
}

enum status command_bench(const struct options *options)
{
    const char *name = options->operands[0] != NULL ? options->operands[0] : experiments[0].name;
    unsigned scenes = 0;
    while (scenes + 1 < OPERANDS_MAX && options->operands[scenes + 1] != NULL)
        scenes++;
    lk_log_set(options->log_level, NULL, NULL);
    progress_catch_interrupts();
    for (size_t i = 0; i < sizeof(experiments) / sizeof(experiments[0]); i++) {
        const struct experiment *experiment = &experiments[i];
        if (strcmp(name, experiment->name) != 0)
            continue;
        if (scenes < experiment->scenes_min || scenes > experiment->scenes_max)
            return status_fail(STATUS_USAGE, "bench %s takes %u to %u scenes, not %u", name,
                               experiment->scenes_min, experiment->scenes_max, scenes);
        return experiment->run(options);
    }
    return status_fail(
        STATUS_USAGE,
        "there is no experiment %s; there are report, lights, trace, memory and scale", name);
}
