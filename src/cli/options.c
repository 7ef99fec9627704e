#include "cli/options.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"
#include "core/choices.h"

// Columns of a row from `type` on.
#define FLAG(field)              OPTION_FLAG, offsetof(struct options, field), 0, 0, NULL
#define TEXT(field)              OPTION_TEXT, offsetof(struct options, field), 0, 0, NULL
#define UINT(field, low, top)    OPTION_UINT, offsetof(struct options, field), low, top, NULL
#define MEGABYTES(field)         OPTION_MEGABYTES, offsetof(struct options, field), 1, 1e9, NULL
#define FLOAT(field, low, top)   OPTION_FLOAT, offsetof(struct options, field), low, top, NULL
#define FLOATS2(field, low, top) OPTION_FLOATS2, offsetof(struct options, field), low, top, NULL
#define FLOATS3(field, low, top) OPTION_FLOATS3, offsetof(struct options, field), low, top, NULL
#define DOUBLE(field, low, top)  OPTION_DOUBLE, offsetof(struct options, field), low, top, NULL
#define CHOICE(field, words)     OPTION_CHOICE, offsetof(struct options, field), 0, 0, words
#define HEADING(commands, text)                                                                    \
    {                                                                                              \
        NULL, 0, commands, NULL, text, NULL, 0, 0, 0, 0, NULL                                      \
    }

#define RENDER  COMMAND_RENDER
#define COMPARE COMMAND_COMPARE
#define INFO    COMMAND_INFO
#define DEVICES COMMAND_DEVICES
#define BENCH   COMMAND_BENCH
#define BOTH    (COMMAND_RENDER | COMMAND_BENCH)
#define SIZED   (BOTH | INFO) // what changes the memory a render takes
#define ALL     COMMAND_ALL

// clang-format off
const struct option option_table[] = {
    HEADING(SIZED, "Picture"),
    {"output", 'o', RENDER, "FILE", "the image: .exr .hdr .tif (linear), .png .jpg (8 bits)", NULL, TEXT(output)},
    {"width", 0, SIZED, "N", "image width in pixels", "1024, or by the camera's aspect", UINT(settings.width, 1, 16384)},
    {"height", 0, SIZED, "N", "image height in pixels", "by the camera's aspect", UINT(settings.height, 1, 16384)},
    {"camera", 0, SIZED, "NAME", "camera: its name, its node's name or its index", "the first", TEXT(settings.camera)},
    {"quantity", 0, RENDER, NULL, "what a pixel holds", NULL, CHOICE(settings.quantity, choices_quantity)},
    {"exposure", 0, RENDER, "EV", "stops brighter; 8-bit files only", NULL, FLOAT(display.exposure_ev, -100, 100)},
    {"tonemap", 0, RENDER, NULL, "display transform; 8-bit files only; auto: aces", NULL, CHOICE(display.tonemap, choices_tonemap)},

    HEADING(BOTH, "When to stop (whichever comes first)"),
    {"spp", 0, RENDER, "N", "samples per pixel", "64; no limit with those below", UINT(settings.spp, 1, 1e9)},
    {"time", 0, BOTH, "S", "seconds of rendering", "no limit; bench: the experiment's", DOUBLE(settings.time_s, 0.001, 1e9)},
    {"noise", 0, RENDER, "E", "relative error of the noisiest parts; 0.05 is 5 %", "no limit", FLOAT(settings.noise, 1e-6, 1)},

    HEADING(SIZED, "Light"),
    {"depth", 0, BOTH, "D", "shaded hits of a path; 1: emission and direct light", NULL, UINT(settings.depth, 1, 255)},
    {"roulette-depth", 0, BOTH, "D", "first hits that every path goes on from; 255: all", NULL, UINT(settings.roulette_depth, 0, 255)},
    {"shadow-rays", 0, BOTH, "N", "draws of lights per hit; importance: up to 8 each", NULL, UINT(settings.shadow_rays, 1, 64)},
    {"light-sampler", 0, SIZED, NULL, "which lights a hit looks at", NULL, CHOICE(settings.light_sampler, choices_light_sampler)},
    {"brdf", 0, BOTH, NULL, "metallic-roughness, or diffuse + Phong lobe", NULL, CHOICE(settings.brdf, choices_brdf)},
    {"sampler", 0, RENDER, NULL, "how samples of a pixel are spread", NULL, CHOICE(settings.sampler, choices_sampler)},
    {"seed", 0, BOTH, "N", "another seed gives other noise", NULL, UINT(settings.seed, 0, UINT32_MAX)},

    HEADING(SIZED, "Surroundings (at most one of --env, --sky and --background)"),
    {"env", 0, SIZED, "FILE", "lat-long image, .hdr or .exr; its middle looks along -Z", NULL, TEXT(settings.env)},
    {"env-rotation", 0, BOTH, "DEG", "turns it about +Y", NULL, FLOAT(settings.env_rotation_deg, -1e6, 1e6)},
    {"env-strength", 0, BOTH, "X", "factor of it, or of sky and sun", NULL, FLOAT(settings.env_strength, 0, 1e30)},
    {"sky", 0, SIZED, "AZ,EL", "clear sky; the sun's azimuth (0: -Z, 90: +X) and elevation", NULL, FLOATS2(settings.sky_sun_deg, -360, 360)},
    {"turbidity", 0, BOTH, "T", "haze of the sky, 2 to 10", NULL, FLOAT(settings.sky_turbidity, 2, 10)},
    {"background", 0, SIZED, "R,G,B", "the same radiance from all around, cd/m2", NULL, FLOATS3(settings.background, 0, 1e30)},

    HEADING(SIZED, "Device and kernels"),
    {"device", 0, BOTH, "LIST", "cpu, gpu, P:D, part of a name; or a list; or all", "the best", TEXT(settings.device)},
    {"trace", 0, BOTH, NULL, "a ray per item, a queue, or warps; auto: measured", NULL, CHOICE(settings.trace, choices_trace)},
    {"bvh", 0, SIZED, NULL, "layout; wide: CPUs; quad, compressed: GPUs", NULL, CHOICE(settings.bvh, choices_bvh)},
    {"bvh-build", 0, SIZED, NULL, "its builder: with spatial splits, or the thesis's", NULL, CHOICE(settings.bvh_build, choices_bvh_build)},
    {"textures", 0, RENDER | INFO, NULL, "one launch per material, or one over all texels", NULL, CHOICE(settings.textures, choices_textures)},
    {"nodes", 0, RENDER, NULL, "where kernels read the binary BVH's nodes from", NULL, CHOICE(settings.nodes, choices_nodes)},
    {"split-threshold", 0, SIZED, "A", "m2; larger boxes of triangles are split early; 0: off", NULL, FLOAT(settings.split_threshold, 0, 1e30)},
    {"leaf-size", 0, SIZED, "N", "no leaf has so many triangles", NULL, UINT(settings.leaf_size, 2, 32)},
    {"queue", 0, RENDER | INFO, "N", "paths in flight", "by the device", UINT(settings.queue, 1, 1 << 30)},
    {"memory-limit", 0, BOTH, "MB", "most memory to take on the device", "all it has", MEGABYTES(settings.memory_limit)},
    {"no-cache", 0, BOTH, NULL, "build the kernels from source, measure tracing anew", NULL, FLAG(settings.no_cache)},

    HEADING(BENCH, "Experiments"),
    {"quick", 0, BENCH, NULL, "all of it small: minutes on two cores", NULL, FLAG(quick)},
    {"out", 0, BENCH, "FOLDER", "where report, memory and scale write", "build/bench", TEXT(out)},
    {"reference", 0, BENCH, "PATH", "lights: image of this scene; report: folder", "rendered", TEXT(reference)},
    {"reference-time", 0, BENCH, "S", "seconds to render a reference", "10 times --time", DOUBLE(reference_time_s, 0.001, 1e9)},
    {"runs", 0, BENCH, "N", "trace, path: measured runs of each kind", NULL, UINT(runs, 1, 1000)},
    {"views", 0, BENCH, "N", "trace: 1 is the camera's; more stand all over the level", NULL, UINT(views, 1, 4096)},

    HEADING(RENDER, "Reports"),
    {"stats", 0, RENDER, "FILE", "write a JSON report", NULL, TEXT(stats)},
    {"profile", 0, RENDER, NULL, "time every stage by itself and print a table", NULL, FLAG(settings.profile)},

    HEADING(COMPARE | INFO | DEVICES | BENCH, "Options"),
    {"json", 0, COMPARE | INFO | DEVICES | BENCH, NULL, "print JSON", NULL, FLAG(json)},
    {"diff", 0, COMPARE, "FILE", "write the absolute difference as an image", NULL, TEXT(diff)},

    HEADING(RENDER, "Messages"),
    {"quiet", 0, ALL, NULL, "nothing but errors on stderr", NULL, FLAG(quiet)},
    {"log-level", 0, ALL, NULL, "most that is said on stderr", "warning", CHOICE(log_level, choices_log_level)},
    {"strict", 0, RENDER | INFO, NULL, "warnings are errors (exit code 3)", NULL, FLAG(strict)},
    {"help", 'h', ALL, NULL, "print this text", NULL, FLAG(help)},
    {"version", 0, ALL, NULL, "print version and commit", NULL, FLAG(version)},
    {0},
};
// clang-format on

_Static_assert(sizeof(enum lk_trace) == sizeof(int), "choices are stored as int");

void options_init(struct options *options)
{
    *options =
        (struct options){.log_level = LK_LOG_WARNING, .runs = 7, .views = 1, .out = "build/bench"};
    lk_settings_init(&options->settings);
}

// ---- Words that are close

#define WORD_MAX 64

// Least number of letters to insert, delete or change (V. Levenshtein, 1966).
static size_t distance(const char *a, const char *b)
{
    size_t row[WORD_MAX + 1]; // distances of a's first i letters from b's first j
    const size_t a_size = strlen(a);
    const size_t b_size = strlen(b);
    if (a_size > WORD_MAX || b_size > WORD_MAX)
        return WORD_MAX;

    for (size_t j = 0; j <= b_size; j++)
        row[j] = j;
    for (size_t i = 1; i <= a_size; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= b_size; j++) {
            const size_t change = diagonal + (a[i - 1] != b[j - 1]);
            const size_t insert = (row[j] < row[j - 1] ? row[j] : row[j - 1]) + 1;
            diagonal = row[j];
            row[j] = change < insert ? change : insert;
        }
    }
    return row[b_size];
}

const char *options_closest(const char *word, const char *const *words, size_t count)
{
    const char *closest = NULL;
    size_t least = strlen(word) / 3 + 1; // a third of it may be wrong
    for (size_t i = 0; i < count; i++) {
        const size_t d = words[i] != NULL ? distance(word, words[i]) : WORD_MAX;
        if (d <= least && (closest == NULL || d < least)) {
            closest = words[i];
            least = d;
        }
    }
    return closest;
}

// ---- Values

static enum status fail_range(const struct option *option, const char *value, const char *kind)
{
    return status_fail(STATUS_USAGE, "--%s: \"%s\" is not %s from %.10g to %.10g", option->name,
                       value, kind, option->min, option->max);
}

// Decimal digits only.
static enum status parse_uint(uint64_t *out, const struct option *option, const char *value)
{
    errno = 0;
    char *end = NULL;
    const unsigned long long number = strtoull(value, &end, 10);
    if (!isdigit((unsigned char)value[0]) || *end != '\0' || errno != 0 ||
        (double)number < option->min || (double)number > option->max)
        return fail_range(option, value, "a whole number");
    *out = number;
    return STATUS_OK;
}

static enum status parse_double(double *out, const struct option *option, const char *value)
{
    char *end = NULL;
    const double number = strtod(value, &end);
    if (end == value || *end != '\0' || isspace((unsigned char)value[0]) || !isfinite(number) ||
        number < option->min || number > option->max)
        return fail_range(option, value, "a number");
    *out = number;
    return STATUS_OK;
}

// `count` numbers with commas between.
static enum status parse_floats(float *out, const struct option *option, const char *value,
                                int count)
{
    float numbers[3] = {0};
    const char *at = value;
    for (int i = 0; i < count; i++) {
        char *end = NULL;
        const double number = strtod(at, &end);
        if (end == at || isspace((unsigned char)at[0]) || *end != (i + 1 < count ? ',' : '\0') ||
            !isfinite(number) || number < option->min || number > option->max)
            return status_fail(STATUS_USAGE,
                               "--%s: \"%s\" is not %d numbers from %.10g to %.10g, with commas "
                               "between",
                               option->name, value, count, option->min, option->max);
        numbers[i] = (float)number;
        at = end + 1;
    }
    memcpy(out, numbers, (size_t)count * sizeof(*out));
    return STATUS_OK;
}

static enum status parse_choice(int *out, const struct option *option, const char *value)
{
    char list[256] = "";
    size_t size = 0;
    size_t count = 0;
    for (; option->choices[count] != NULL; count++) {
        if (strcmp(value, option->choices[count]) == 0) {
            *out = (int)count;
            return STATUS_OK;
        }
        size += (size_t)snprintf(list + size, sizeof(list) - size, "%s%s", count > 0 ? ", " : "",
                                 option->choices[count]);
    }
    return status_fail(STATUS_USAGE, "--%s: \"%s\" is none of %s", option->name, value, list);
}

// Stores a value in its field.
static enum status set_value(struct options *options, const struct option *option,
                             const char *value)
{
    void *field = (char *)options + option->offset;
    uint64_t whole = 0;
    double number = 0.0;
    enum status status = STATUS_OK;
    switch (option->type) {
    case OPTION_FLAG:
        *(bool *)field = true;
        break;
    case OPTION_TEXT:
        if (value[0] == '\0')
            return status_fail(STATUS_USAGE, "--%s: its value is empty", option->name);
        *(const char **)field = value;
        break;
    case OPTION_UINT:
        status = parse_uint(&whole, option, value);
        if (status == STATUS_OK)
            *(uint32_t *)field = (uint32_t)whole;
        break;
    case OPTION_MEGABYTES:
        status = parse_uint(&whole, option, value);
        if (status == STATUS_OK)
            *(uint64_t *)field = whole * 1000000u;
        break;
    case OPTION_FLOAT:
        status = parse_double(&number, option, value);
        if (status == STATUS_OK)
            *(float *)field = (float)number;
        break;
    case OPTION_FLOATS2:
        status = parse_floats(field, option, value, 2);
        break;
    case OPTION_FLOATS3:
        status = parse_floats(field, option, value, 3);
        break;
    case OPTION_DOUBLE:
        status = parse_double(&number, option, value);
        if (status == STATUS_OK)
            *(double *)field = number;
        break;
    case OPTION_CHOICE:
        status = parse_choice(field, option, value);
        break;
    }
    return status;
}

// ---- Arguments

static const struct option *find_long(enum command command, const char *name, size_t size)
{
    for (const struct option *o = option_table; o->help != NULL; o++)
        if ((o->commands & command) != 0 && o->name != NULL && strlen(o->name) == size &&
            memcmp(o->name, name, size) == 0)
            return o;
    return NULL;
}

static const struct option *find_short(enum command command, char letter)
{
    for (const struct option *o = option_table; o->help != NULL; o++)
        if ((o->commands & command) != 0 && o->letter == letter)
            return o;
    return NULL;
}

static enum status fail_unknown(enum command command, const char *argument, size_t size)
{
    const char *names[64];
    size_t count = 0;
    for (const struct option *o = option_table; o->help != NULL; o++)
        if ((o->commands & command) != 0 && count < sizeof(names) / sizeof(names[0]))
            names[count++] = o->name;

    char name[WORD_MAX] = "";
    snprintf(name, sizeof(name), "%.*s", (int)size - 2, argument + 2);
    const char *closest = size > 2 ? options_closest(name, names, count) : NULL;
    if (closest != NULL)
        return status_fail(STATUS_USAGE, "there is no option %.*s; did you mean --%s?", (int)size,
                           argument, closest);
    return status_fail(STATUS_USAGE, "there is no option %.*s; see lightkiln %s --help", (int)size,
                       argument, command_name(command));
}

// Takes the option at args[*at], and the next argument if that is its value.
static enum status parse_option(struct options *options, uint64_t *given, enum command command,
                                char *const *args, int count, int *at)
{
    const char *argument = args[*at];
    const bool is_long = argument[1] == '-';
    const size_t size = is_long ? strcspn(argument, "=") : 2;
    const struct option *option =
        is_long ? find_long(command, argument + 2, size - 2) : find_short(command, argument[1]);
    if (option == NULL)
        return fail_unknown(command, argument, size);

    // Find the value: in the same argument or in the next.
    const char *value = NULL;
    if (argument[size] != '\0')
        value = argument + size + (argument[size] == '=');
    if (option->type == OPTION_FLAG && value != NULL)
        return status_fail(STATUS_USAGE, "--%s takes no value", option->name);
    if (option->type != OPTION_FLAG && value == NULL) {
        const bool follows = *at + 1 < count && strncmp(args[*at + 1], "--", 2) != 0;
        if (!follows)
            return status_fail(STATUS_USAGE, "--%s needs a value", option->name);
        value = args[++*at];
    }
    *given |= (uint64_t)1 << (option - option_table);
    return set_value(options, option, value);
}

static bool is_given(uint64_t given, const char *name)
{
    const struct option *option = find_long(COMMAND_ALL, name, strlen(name));
    return (given >> (option - option_table) & 1) != 0;
}

enum status options_parse(struct options *options, enum command command, char *const *args,
                          int count)
{
    _Static_assert(sizeof(option_table) / sizeof(option_table[0]) <= 64, "given is one word");
    uint64_t given = 0; // bit i: row i of the table was on the command line
    unsigned operand_count = 0;
    bool only_operands = false; // after "--"
    options_init(options);

    for (int i = 0; i < count; i++) {
        const char *argument = args[i];
        if (!only_operands && strcmp(argument, "--") == 0) {
            only_operands = true;
        } else if (!only_operands && argument[0] == '-' && argument[1] != '\0') {
            const enum status status = parse_option(options, &given, command, args, count, &i);
            if (status != STATUS_OK)
                return status;
        } else if (operand_count < command_operands_most(command)) {
            options->operands[operand_count++] = argument;
        } else {
            return status_fail(STATUS_USAGE, "%s is one file too many; usage: lightkiln %s %s",
                               argument, command_name(command), command_operands(command));
        }
    }

    if (options->help || options->version)
        return STATUS_OK;
    if (operand_count < command_operands_least(command))
        return status_fail(STATUS_USAGE, "a file is missing; usage: lightkiln %s %s",
                           command_name(command), command_operands(command));

    // Other limits stand alone unless samples are asked for, too.
    if ((is_given(given, "time") || is_given(given, "noise")) && !is_given(given, "spp"))
        options->settings.spp = 0;
    if (options->quiet && !is_given(given, "log-level"))
        options->log_level = LK_LOG_ERROR;
    return STATUS_OK;
}
