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
    {"path", bench_pipeline, 1, 1},
    {"memory", bench_memory, 0, OPERANDS_MAX - 1},
    {"scale", bench_scale, 0, 0},
};

// Fails if an option is given that the experiment has no use for: it would be ignored.
static enum status refuse(const char *experiment, const struct options *options)
{
    struct options defaults;
    options_init(&defaults);
    const struct lk_settings *given = &options->settings;
    const struct lk_settings *none = &defaults.settings;
    const struct {
        const char *name, *users;
        bool is_given;
    } uses[] = {
        {"width", "lights trace path", given->width != none->width},
        {"height", "lights trace path", given->height != none->height},
        {"camera", "lights trace path", given->camera != none->camera},
        {"depth", "lights path", given->depth != none->depth},
        {"roulette-depth", "lights path", given->roulette_depth != none->roulette_depth},
        {"shadow-rays", "lights path", given->shadow_rays != none->shadow_rays},
        {"light-sampler", "path", given->light_sampler != none->light_sampler},
        {"time", "lights path report memory scale", given->time_s != none->time_s},
        {"reference", "lights report", options->reference != NULL},
        {"reference-time", "lights report", options->reference_time_s > 0.0},
        {"runs", "trace path", options->runs != defaults.runs},
        {"views", "trace", options->views != defaults.views},
        {"quick", "report memory scale", options->quick},
        {"out", "report memory scale", strcmp(options->out, defaults.out) != 0},
    };
    for (size_t i = 0; i < sizeof(uses) / sizeof(uses[0]); i++)
        if (uses[i].is_given && strstr(uses[i].users, experiment) == NULL)
            return status_fail(STATUS_USAGE, "bench %s has no use for --%s; it is for %s",
                               experiment, uses[i].name, uses[i].users);
    return STATUS_OK;
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
        if (scenes < experiment->scenes_min)
            return status_fail(STATUS_USAGE, "say which scene: lightkiln bench %s SCENE", name);
        if (scenes > experiment->scenes_max)
            return status_fail(STATUS_USAGE, "bench %s: %s is one scene too many", name,
                               options->operands[experiment->scenes_max + 1]);
        const enum status status = refuse(name, options);
        if (status != STATUS_OK)
            return status;
        return experiment->run(options);
    }
    return status_fail(
        STATUS_USAGE,
        "there is no experiment %s; there are report, lights, trace, path, memory and scale", name);
}
