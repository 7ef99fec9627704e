#include "cli/bench.h"

#include <string.h>

#include "cli/commands.h"
#include "cli/progress.h"

enum status command_bench(const struct options *options)
{
    static const struct {
        const char *name;
        enum status (*run)(const struct options *options);
    } experiments[] = {{"lights", bench_lights}, {"trace", bench_trace}};
    lk_log_set(options->log_level, NULL, NULL);
    progress_catch_interrupts();
    for (size_t i = 0; i < sizeof(experiments) / sizeof(experiments[0]); i++)
        if (strcmp(options->operands[0], experiments[i].name) == 0)
            return experiments[i].run(options);
    return status_fail(STATUS_USAGE, "there is no experiment %s; there are lights and trace",
                       options->operands[0]);
}
