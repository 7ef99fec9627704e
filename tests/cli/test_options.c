// Laws of the option table, and of parsing with it.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cli/commands.h"
#include "cli/options.h"

static enum status parse(struct options *out, enum command command, const char *line)
{
    // Split at blanks; the words stay valid for the test.
    static char text[512];
    char *args[32];
    int count = 0;
    snprintf(text, sizeof(text), "%s", line);
    for (char *word = strtok(text, " "); word != NULL; word = strtok(NULL, " "))
        args[count++] = word;
    return options_parse(out, command, args, count);
}

static enum status parse_render(struct options *out, const char *line)
{
    return parse(out, COMMAND_RENDER, line);
}

static void names_are_unique_and_rows_complete(void **state)
{
    (void)state;
    for (const struct option *a = option_table; a->help != NULL; a++) {
        assert_true((a->commands & COMMAND_ALL) == a->commands && a->commands != 0);
        if (a->name == NULL)
            continue;
        assert_true(a->offset < sizeof(struct options));
        assert_true((a->choices != NULL) == (a->type == OPTION_CHOICE));
        const bool has_argument = a->type != OPTION_FLAG && a->type != OPTION_CHOICE;
        assert_true((a->argument != NULL) == has_argument);
        for (const struct option *b = a + 1; b->help != NULL; b++) {
            if (b->name == NULL)
                continue;
            assert_string_not_equal(a->name, b->name);
            assert_true(a->letter == '\0' || a->letter != b->letter);
            assert_true(a->offset != b->offset);
        }
    }
}

static void defaults_lie_within_their_ranges(void **state)
{
    (void)state;
    struct options defaults;
    options_init(&defaults);
    for (const struct option *o = option_table; o->help != NULL; o++) {
        const void *field = (const char *)&defaults + o->offset;
        double value = o->min;
        if (o->type == OPTION_UINT)
            value = *(const uint32_t *)field;
        else if (o->type == OPTION_FLOAT)
            value = (double)*(const float *)field;
        // A default outside is "none" and is said in words.
        assert_true((value >= o->min && value <= o->max) || o->none != NULL);
    }
}

static void every_option_is_taken_and_lands_in_its_field(void **state)
{
    (void)state;
    for (const struct option *o = option_table; o->help != NULL; o++) {
        if (o->name == NULL || (o->commands & COMMAND_RENDER) == 0)
            continue;
        char value[128] = "text";
        if (o->type == OPTION_CHOICE) {
            size_t last = 0;
            while (o->choices[last + 1] != NULL)
                last++;
            snprintf(value, sizeof(value), "%s", o->choices[last]);
        } else if (o->type == OPTION_FLOATS2) {
            snprintf(value, sizeof(value), "%.0f,%.0f", o->max, o->min);
        } else if (o->type == OPTION_FLOATS3) {
            snprintf(value, sizeof(value), "%.0f,%.0f,%.0f", o->max, o->min, o->max);
        } else if (o->type != OPTION_TEXT) {
            snprintf(value, sizeof(value), "%.0f", o->max);
        }
        char line[256];
        snprintf(line, sizeof(line), "a.glb --%s%s%s", o->name, o->type == OPTION_FLAG ? "" : "=",
                 o->type == OPTION_FLAG ? "" : value);

        struct options options;
        struct options defaults;
        options_init(&defaults);
        if (parse_render(&options, line) != STATUS_OK)
            fail_msg("%s: %s", line, status_message());
        const bool wide =
            o->type == OPTION_TEXT || o->type == OPTION_MEGABYTES || o->type == OPTION_DOUBLE;
        const size_t size = o->type == OPTION_FLAG ? sizeof(bool) : wide ? 8 : 4;
        assert_memory_not_equal((char *)&options + o->offset, (char *)&defaults + o->offset, size);
    }
}

static void numbers_outside_their_range_are_refused(void **state)
{
    (void)state;
    static const char *const wrong[] = {
        "-1", "x", "1x", "", "nan", "inf", "99999999999999999999", "0x10", "1e99"};
    struct options options;
    for (const struct option *o = option_table; o->help != NULL; o++) {
        if (o->name == NULL || (o->commands & COMMAND_RENDER) == 0 || o->max == 0.0)
            continue;
        for (size_t i = 0; i < sizeof(wrong) / sizeof(wrong[0]); i++) {
            char line[128];
            snprintf(line, sizeof(line), "a.glb --%s=%s", o->name, wrong[i]);
            const double value = strtod(wrong[i], NULL);
            const bool real = o->type == OPTION_FLOAT || o->type == OPTION_DOUBLE;
            if (real && wrong[i][0] != '\0' && strchr(wrong[i], 'x') == NULL && value >= o->min &&
                value <= o->max)
                continue; // right for this one
            if (real && strcmp(wrong[i], "0x10") == 0)
                continue; // a number, in C's way
            if (parse_render(&options, line) != STATUS_USAGE)
                fail_msg("%s is accepted", line);
            assert_non_null(strstr(status_message(), o->name));
        }
    }
}

static void lists_of_numbers_are_taken_whole(void **state)
{
    (void)state;
    struct options options;
    assert_int_equal(parse_render(&options, "a.glb --background 0.5,1e-1,2 --sky -90,.5"),
                     STATUS_OK);
    assert_true(options.settings.background[1] == 0.1f && options.settings.background[2] == 2.0f);
    assert_true(options.settings.sky_sun_deg[0] == -90.0f);
    const char *const wrong[] = {"1,2", "1,2,3,4", "1,,3", "1,2,", "1,2,-3", "1;2;3", "nan,1,1"};
    for (size_t i = 0; i < sizeof(wrong) / sizeof(wrong[0]); i++) {
        char line[64];
        snprintf(line, sizeof(line), "a.glb --background=%s", wrong[i]);
        assert_int_equal(parse_render(&options, line), STATUS_USAGE);
    }
}

static void forms_of_an_option_are_equal(void **state)
{
    (void)state;
    static const char *const lines[] = {
        "a.glb -o b.exr --depth 7", "a.glb -ob.exr --depth=7", "--output b.exr --depth 7 a.glb",
        "--output=b.exr a.glb --depth=7", "-o b.exr --depth 3 --depth 7 -- a.glb"};
    for (size_t i = 0; i < sizeof(lines) / sizeof(lines[0]); i++) {
        struct options options;
        assert_int_equal(parse_render(&options, lines[i]), STATUS_OK);
        assert_string_equal(options.operands[0], "a.glb");
        assert_string_equal(options.output, "b.exr");
        assert_int_equal(options.settings.depth, 7);
    }
}

static void negative_numbers_and_dashes_are_values(void **state)
{
    (void)state;
    struct options options;
    assert_int_equal(parse_render(&options, "- --exposure -1.5"), STATUS_OK);
    assert_string_equal(options.operands[0], "-");
    assert_true(options.display.exposure_ev == -1.5f);
    assert_int_equal(parse_render(&options, "-- --strange.glb"), STATUS_OK);
    assert_string_equal(options.operands[0], "--strange.glb");
}

static void mistakes_are_named(void **state)
{
    (void)state;
    static const struct {
        const char *line, *message;
    } cases[] = {
        {"a.glb --shadowrays 2", "there is no option --shadowrays; did you mean --shadow-rays?"},
        {"a.glb --ssp=2", "there is no option --ssp; did you mean --spp?"},
        {"a.glb --entirely-else",
         "there is no option --entirely-else; see lightkiln render --help"},
        {"a.glb -x", "there is no option -x; see lightkiln render --help"},
        {"a.glb --json", "there is no option --json"},
        {"a.glb --spp", "--spp needs a value"},
        {"a.glb --output --spp 2", "--output needs a value"},
        {"a.glb --quiet=yes", "--quiet takes no value"},
        {"a.glb --trace fast", "--trace: \"fast\" is none of auto, simple, persistent"},
        {"a.glb --depth 0", "--depth: \"0\" is not a whole number from 1 to 255"},
        {"a.glb b.glb", "b.glb is one file too many"},
        {"", "a file is missing"},
    };
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        struct options options;
        assert_int_equal(parse_render(&options, cases[i].line), STATUS_USAGE);
        if (strncmp(status_message(), cases[i].message, strlen(cases[i].message)) != 0)
            fail_msg("%s: %s", cases[i].line, status_message());
    }
}

static void time_alone_lifts_the_limit_of_samples(void **state)
{
    (void)state;
    struct options options;
    assert_int_equal(parse_render(&options, "a.glb"), STATUS_OK);
    assert_int_equal(options.settings.spp, 64);
    assert_int_equal(parse_render(&options, "a.glb --time 2"), STATUS_OK);
    assert_int_equal(options.settings.spp, 0);
    assert_int_equal(parse_render(&options, "a.glb --time 2 --spp 9"), STATUS_OK);
    assert_int_equal(options.settings.spp, 9);
}

static void quiet_hides_warnings_unless_asked_for(void **state)
{
    (void)state;
    struct options options;
    assert_int_equal(parse_render(&options, "a.glb"), STATUS_OK);
    assert_int_equal(options.log_level, LK_LOG_WARNING);
    assert_int_equal(parse_render(&options, "a.glb --quiet"), STATUS_OK);
    assert_int_equal(options.log_level, LK_LOG_ERROR);
    assert_int_equal(parse_render(&options, "a.glb --quiet --log-level info"), STATUS_OK);
    assert_int_equal(options.log_level, LK_LOG_INFO);
}

static void commands_have_options_of_their_own(void **state)
{
    (void)state;
    struct options options;
    assert_int_equal(parse(&options, COMMAND_COMPARE, "a.exr b.exr --json --diff c.exr"),
                     STATUS_OK);
    assert_true(options.json);
    assert_string_equal(options.operands[1], "b.exr");
    assert_string_equal(options.diff, "c.exr");
    assert_int_equal(parse(&options, COMMAND_COMPARE, "a.exr"), STATUS_USAGE);
    assert_int_equal(parse(&options, COMMAND_COMPARE, "a.exr b.exr --spp 2"), STATUS_USAGE);
    assert_int_equal(parse(&options, COMMAND_DEVICES, ""), STATUS_OK);
    assert_int_equal(parse(&options, COMMAND_DEVICES, "a"), STATUS_USAGE);
    assert_int_equal(parse(&options, COMMAND_COMPARE, "--help"), STATUS_OK);
    assert_true(options.help);
}

// What `info` counts it can be asked for; what changes no size it does not take and ignore.
static void info_takes_what_changes_memory(void **state)
{
    (void)state;
    struct options options;
    assert_int_equal(parse(&options, COMMAND_INFO,
                           "a.glb --width 64 --height 32 --camera door --env a.hdr --leaf-size 4 "
                           "--split-threshold 1 --light-sampler tree --textures bound --queue 99"),
                     STATUS_OK);
    assert_int_equal(options.settings.width, 64);
    assert_string_equal(options.settings.env, "a.hdr");
    assert_int_equal(parse(&options, COMMAND_INFO, "a.glb --sky 10,20"), STATUS_OK);
    assert_int_equal(parse(&options, COMMAND_INFO, "a.glb --background 1,1,1"), STATUS_OK);
    static const char *const refused[] = {"a.glb --env-rotation 3", "a.glb --env-strength 2",
                                          "a.glb --turbidity 3",    "a.glb --depth 2",
                                          "a.glb --seed 2",         "a.glb --spp 2"};
    for (size_t i = 0; i < sizeof(refused) / sizeof(refused[0]); i++)
        assert_int_equal(parse(&options, COMMAND_INFO, refused[i]), STATUS_USAGE);
}

static void commands_are_found_by_name(void **state)
{
    (void)state;
    static const char *const names[] = {"render", "compare", "info", "devices"};
    for (size_t i = 0; i < 4; i++)
        assert_string_equal(command_name(command_find(names[i])), names[i]);
    assert_int_equal(command_find("bench2"), 0);
    assert_string_equal(command_closest("rendr"), "render");
    assert_null(command_closest("teapot"));
}

static void help_names_every_option_within_100_columns(void **state)
{
    (void)state;
    char *text = NULL;
    size_t size = 0;
    FILE *file = open_memstream(&text, &size);
    assert_non_null(file);
    help_print(file);
    for (unsigned command = 1; command < COMMAND_ALL; command *= 2)
        help_print_command(file, command);
    assert_int_equal(fclose(file), 0);

    for (const struct option *o = option_table; o->help != NULL; o++) {
        char name[64];
        snprintf(name, sizeof(name), "--%s", o->name != NULL ? o->name : "help");
        assert_non_null(strstr(text, name));
    }
    for (const char *line = text; *line != '\0'; line += strcspn(line, "\n") + 1)
        if (strcspn(line, "\n") > 100)
            fail_msg("too long: %.*s", (int)strcspn(line, "\n"), line);
    free(text);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(names_are_unique_and_rows_complete),
        cmocka_unit_test(defaults_lie_within_their_ranges),
        cmocka_unit_test(every_option_is_taken_and_lands_in_its_field),
        cmocka_unit_test(numbers_outside_their_range_are_refused),
        cmocka_unit_test(lists_of_numbers_are_taken_whole),
        cmocka_unit_test(forms_of_an_option_are_equal),
        cmocka_unit_test(negative_numbers_and_dashes_are_values),
        cmocka_unit_test(mistakes_are_named),
        cmocka_unit_test(time_alone_lifts_the_limit_of_samples),
        cmocka_unit_test(quiet_hides_warnings_unless_asked_for),
        cmocka_unit_test(commands_have_options_of_their_own),
        cmocka_unit_test(info_takes_what_changes_memory),
        cmocka_unit_test(commands_are_found_by_name),
        cmocka_unit_test(help_names_every_option_within_100_columns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
