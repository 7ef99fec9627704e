// The lightkiln command: options in, exit code out, and the one error line.

#include <stdio.h>
#include <string.h>
#include <strings.h>

#include "cli/commands.h"
#include "cli/options.h"
#include "core/status.h"
#include "lightkiln/lightkiln.h"

static int exit_code(enum status status)
{
    switch (status) {
    case STATUS_OK:
        return 0;
    case STATUS_USAGE:
        return 2;
    case STATUS_IO:
    case STATUS_FORMAT:
    case STATUS_UNSUPPORTED:
    case STATUS_LIMIT:
        return 3;
    case STATUS_NO_DEVICE:
        return 4;
    case STATUS_NO_MEMORY:
        return 5;
    case STATUS_WRITE:
        return 6;
    case STATUS_CANCELLED:
        return 130;
    case STATUS_DEVICE:
        break;
    }
    return 1;
}

static bool is_scene(const char *name)
{
    const char *dot = strrchr(name, '.');
    return dot != NULL && (strcasecmp(dot, ".gltf") == 0 || strcasecmp(dot, ".glb") == 0);
}

// Runs what the arguments after the program's name ask for.
static enum status run(char *const *args, int count)
{
    if (count == 0)
        return status_fail(STATUS_USAGE, "say what to do: lightkiln render SCENE -o FILE; see "
                                         "lightkiln --help");
    if (strcmp(args[0], "--help") == 0 || strcmp(args[0], "-h") == 0) {
        help_print(stdout);
        return STATUS_OK;
    }

    // The word render may be left out.
    enum command command = command_find(args[0]);
    const bool named = command != 0;
    if (!named && (args[0][0] == '-' || is_scene(args[0])))
        command = COMMAND_RENDER;
    if (command == 0) {
        const char *closest = command_closest(args[0]);
        return status_fail(STATUS_USAGE, "there is no command %s; %s%s%s", args[0],
                           closest != NULL ? "did you mean " : "see lightkiln --help",
                           closest != NULL ? closest : "", closest != NULL ? "?" : "");
    }

    struct options options;
    const enum status status = options_parse(&options, command, args + named, count - named);
    if (status != STATUS_OK)
        return status;
    if (options.version) {
        printf("lightkiln %s\n", lk_version());
        return STATUS_OK;
    }
    if (options.help) {
        help_print_command(stdout, command);
        return STATUS_OK;
    }
    return command_run(command, &options);
}

int main(int argc, char **argv)
{
    enum status status = run(argv + 1, argc - 1);
    const int flushed = fflush(stdout);
    if ((flushed != 0 || ferror(stdout)) && status == STATUS_OK)
        status = status_fail(STATUS_WRITE, "standard output: cannot write");
    if (status != STATUS_OK && status != STATUS_CANCELLED)
        fprintf(stderr, "lightkiln: error: %s\n", lk_error());
    return exit_code(status);
}
