/**
 * @file
 * The command line: one table of options drives parsing, defaults and help, for every command.
 *
 * Options are --name VALUE, --name=VALUE, -x VALUE or -xVALUE, before, between or after the
 * operands; "--" ends them. The last of equal ones counts. Names are never abbreviated.
 */
#ifndef CLI_OPTIONS_H
#define CLI_OPTIONS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/status.h"
#include "lightkiln/lightkiln.h"

/** The commands that an option belongs to; a command is one of these bits. */
enum command {
    COMMAND_RENDER = 1,
    COMMAND_COMPARE = 2,
    COMMAND_INFO = 4,
    COMMAND_DEVICES = 8,
    COMMAND_BENCH = 16,
    COMMAND_ALL = 31
};

#define OPERANDS_MAX 9

/** Everything that a command line can say. Strings are borrowed from it. */
struct options {
    const char *operands[OPERANDS_MAX]; // scene; image and reference; experiment and scenes; NULL
    struct lk_settings settings;
    struct lk_display display;
    const char *output, *stats, *diff, *reference; // files; NULL: none
    const char *out;                               // folder of what bench writes
    double reference_time_s;
    uint32_t runs;  // measured runs of each kind
    uint32_t views; // that traced rays come from
    enum lk_log_level log_level;
    bool quick, json, quiet, strict, help, version;
};

enum option_type {
    OPTION_FLAG,      // bool
    OPTION_TEXT,      // const char *
    OPTION_UINT,      // uint32_t
    OPTION_MEGABYTES, // uint64_t in bytes
    OPTION_FLOAT,     // float
    OPTION_FLOATS2,   // float[2], with a comma between
    OPTION_FLOATS3,   // float[3]
    OPTION_DOUBLE,    // double
    OPTION_CHOICE     // an enum
};

struct option {
    const char *name;     // without dashes; NULL: a heading, its text is in `help`
    char letter;          // of the short form, or 0
    unsigned commands;    // enum command bits
    const char *argument; // what help calls the value; NULL for flags and choices
    const char *help;
    const char *none; // what happens without it, where that is no value of the field
    enum option_type type;
    size_t offset;              // of its field in struct options
    double min, max;            // of numbers, inclusive
    const char *const *choices; // words in the order of the enum, then NULL
};

/** The table; ends with an all-zero row. */
extern const struct option option_table[];

/** Fills in every default. */
void options_init(struct options *options);

/**
 * Parses the arguments after the command's name.
 *
 * @param[out] options  Complete on success only.
 * @param args          [count], as main() has them.
 * @retval STATUS_USAGE  The message names the argument and, for a misspelt one, what is close.
 */
enum status options_parse(struct options *options, enum command command, char *const *args,
                          int count);

/**
 * The word of a list that is closest to a misspelt one; NULL if none is close.
 *
 * @param words  [count], NULL entries are passed over.
 */
const char *options_closest(const char *word, const char *const *words, size_t count);

#endif
