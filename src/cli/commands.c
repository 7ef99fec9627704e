#include "cli/commands.h"

#include <string.h>

struct command_row {
    enum command command;
    const char *name;
    const char *operands; // of the usage line
    unsigned operands_least, operands_most;
    enum status (*run)(const struct options *options);
};

static const struct command_row commands[] = {
    {COMMAND_RENDER, "render", "SCENE -o FILE [OPTION...]", 1, 1, command_render},
    {COMMAND_COMPARE, "compare", "IMAGE REFERENCE [OPTION...]", 2, 2, command_compare},
    {COMMAND_INFO, "info", "SCENE [OPTION...]", 1, 1, command_info},
    {COMMAND_DEVICES, "devices", "[OPTION...]", 0, 0, command_devices},
    {COMMAND_BENCH, "bench", "[EXPERIMENT [SCENE...]] [OPTION...]", 0, OPERANDS_MAX, command_bench},
};

#define COMMAND_COUNT (sizeof(commands) / sizeof(commands[0]))

static const struct command_row *row_of(enum command command)
{
    size_t i = 0;
    while (i + 1 < COMMAND_COUNT && commands[i].command != command)
        i++;
    return &commands[i];
}

enum command command_find(const char *name)
{
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        if (strcmp(commands[i].name, name) == 0)
            return commands[i].command;
    return 0;
}

const char *command_name(enum command command)
{
    return row_of(command)->name;
}

const char *command_operands(enum command command)
{
    return row_of(command)->operands;
}

unsigned command_operands_least(enum command command)
{
    return row_of(command)->operands_least;
}

unsigned command_operands_most(enum command command)
{
    return row_of(command)->operands_most;
}

enum status command_run(enum command command, const struct options *options)
{
    return row_of(command)->run(options);
}

const char *command_closest(const char *name)
{
    const char *names[COMMAND_COUNT];
    for (size_t i = 0; i < COMMAND_COUNT; i++)
        names[i] = commands[i].name;
    return options_closest(name, names, COMMAND_COUNT);
}
