/**
 * @file
 * What the lightkiln command can do: one function for each, in a file of its own.
 */
#ifndef CLI_COMMANDS_H
#define CLI_COMMANDS_H

#include <stdio.h>

#include "cli/options.h"
#include "core/status.h"

/** Renders a scene into an image file. STATUS_CANCELLED if interrupted, with the image written. */
enum status command_render(const struct options *options);

/** Prints how far an image is from a reference. */
enum status command_compare(const struct options *options);

/** Prints what a scene holds and what it will take. */
enum status command_info(const struct options *options);

/** Prints the OpenCL devices. */
enum status command_devices(const struct options *options);

/** Measures. The first operand says what, and is "report" if there is none. */
enum status command_bench(const struct options *options);

/** Finds a command by its name; 0 if there is none. */
enum command command_find(const char *name);

/** The name of a command. */
const char *command_name(enum command command);

/** What follows the name in a usage line. */
const char *command_operands(enum command command);

/** Operands that must be given. */
unsigned command_operands_least(enum command command);

/** Operands that may be given, at most OPERANDS_MAX. */
unsigned command_operands_most(enum command command);

/** Runs a command. */
enum status command_run(enum command command, const struct options *options);

/** The command closest to a misspelt name; NULL if none is close. */
const char *command_closest(const char *name);

/** Prints the program's help, which teaches it, with the options of render. */
void help_print(FILE *file);

/** Prints one command's help. */
void help_print_command(FILE *file, enum command command);

#endif
