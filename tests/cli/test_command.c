// The command as a user meets it: exit codes, one error line, stdout for results only. LIGHTKILN
// names the program; no device is needed.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "core/file.h"
#include "scene/image_io.h"
#include "folder.h"

// What a run of the command gave.
struct result {
    int code;
    char *out, *err; // owned
};

// Runs the command with up to 8 arguments; the list ends with NULL.
static struct result run(const char *first, ...)
{
    const char *program = getenv("LIGHTKILN");
    const char *args[16] = {program != NULL ? program : "build/lightkiln"};
    va_list list;
    va_start(list, first);
    const char *arg = first;
    for (int i = 1; arg != NULL && i < 15; i++, arg = va_arg(list, const char *))
        args[i] = arg;
    va_end(list);

    char out_path[512];
    char err_path[512];
    snprintf(out_path, sizeof(out_path), "%s/stdout", folder);
    snprintf(err_path, sizeof(err_path), "%s/stderr", folder);
    const pid_t child = fork();
    assert_true(child >= 0);
    if (child == 0) {
        const int out = open(out_path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
        const int err = open(err_path, O_WRONLY | O_CREAT | O_TRUNC, 0600);
        dup2(out, STDOUT_FILENO);
        dup2(err, STDERR_FILENO);
        execv(args[0], (char *const *)args);
        _exit(127);
    }

    int wait_status = 0;
    assert_int_equal(waitpid(child, &wait_status, 0), child);
    struct result result = {.code = WIFEXITED(wait_status) ? WEXITSTATUS(wait_status) : -1};
    size_t size = 0;
    assert_int_equal(file_read(&result.out, &size, out_path), STATUS_OK);
    assert_int_equal(file_read(&result.err, &size, err_path), STATUS_OK);
    return result;
}

static void release(struct result *result)
{
    free(result->out);
    free(result->err);
}

// The run failed with this code, said one error line that holds `text`, and printed nothing else.
static void assert_fails(struct result result, int code, const char *text)
{
    if (result.code != code || strncmp(result.err, "lightkiln: error: ", 18) != 0 ||
        strstr(result.err, text) == NULL ||
        strchr(result.err, '\n') + 1 != strchr(result.err, '\0') || result.out[0] != '\0')
        fail_msg("code %d, not %d; stderr: %s; stdout: %s", result.code, code, result.err,
                 result.out);
    release(&result);
}

static void assert_prints(struct result result, const char *text)
{
    if (result.code != 0 || strstr(result.out, text) == NULL || result.err[0] != '\0')
        fail_msg("code %d; stderr: %s; stdout: %s", result.code, result.err, result.out);
    release(&result);
}

static void write_image(const char *name, uint32_t width, float value)
{
    float rgb[64 * 3];
    for (uint32_t i = 0; i < width * 3; i++)
        rgb[i] = value;
    assert_int_equal(image_write_rgb(in_folder(name), rgb, width, 1, NULL, 0), STATUS_OK);
}

static void help_and_version_go_to_stdout(void **state)
{
    (void)state;
    assert_prints(run("--help", NULL), "Examples:");
    assert_prints(run("-h", NULL), "lightkiln compare IMAGE REFERENCE");
    assert_prints(run("render", "--help", NULL), "--light-sampler auto|tree");
    assert_prints(run("compare", "--help", NULL), "--diff FILE");
    assert_prints(run("--version", NULL), "lightkiln 0.");
}

static void wrong_usage_is_2(void **state)
{
    (void)state;
    assert_fails(run(NULL), 2, "lightkiln --help");
    assert_fails(run("rendr", NULL), 2, "did you mean render?");
    assert_fails(run("teapot", NULL), 2, "see lightkiln --help");
    assert_fails(run("render", "a.glb", "--depht", "2", NULL), 2, "did you mean --depth?");
    assert_fails(run("render", "a.glb", NULL), 2, "-o FILE.exr");
    assert_fails(run("render", "a.glb", "-o", in_folder("a.bmp"), NULL), 2, "a.bmp");
    assert_fails(run("a.glb", "-o", in_folder("a.exr"), "--depth", "0", NULL), 2, "--depth");
    assert_fails(run("compare", "a.exr", NULL), 2, "usage: lightkiln compare IMAGE REFERENCE");
}

static void bad_input_is_3(void **state)
{
    (void)state;
    assert_int_equal(file_write(in_folder("bad.glb"), "nonsense", 8), STATUS_OK);
    assert_int_equal(file_write(in_folder("bad.exr"), "nonsense", 8), STATUS_OK);
    assert_fails(run("render", in_folder("no.glb"), "-o", in_folder("a.exr"), NULL), 3, "no.glb");
    assert_fails(run(in_folder("bad.glb"), "-o", in_folder("a.exr"), NULL), 3, "bad.glb");
    assert_fails(run("info", in_folder("bad.glb"), NULL), 3, "bad.glb");
    assert_fails(run("compare", in_folder("no.exr"), in_folder("no.exr"), NULL), 3, "no.exr");
    assert_fails(run("compare", in_folder("bad.exr"), in_folder("bad.exr"), NULL), 3, "bad.exr");

    write_image("one.exr", 1, 0.0f);
    write_image("two.exr", 2, 0.0f);
    assert_fails(run("compare", in_folder("one.exr"), in_folder("two.exr"), NULL), 3, "size");
}

static void what_cannot_be_written_is_6_before_the_scene_is_read(void **state)
{
    (void)state;
    assert_fails(run("render", in_folder("no.glb"), "-o", in_folder("none/a.exr"), NULL), 6,
                 "does not exist");
    assert_fails(run("render", in_folder("no.glb"), "-o", in_folder("a.exr"), "--stats",
                     in_folder("none/a.json"), NULL),
                 6, "none/a.json");
}

static void compare_tells_the_difference(void **state)
{
    (void)state;
    write_image("one.exr", 4, 1.0f);
    write_image("two.exr", 4, 1.5f);
    assert_prints(run("compare", in_folder("one.exr"), in_folder("two.exr"), NULL),
                  "RMSE            0.5\n");
    assert_prints(run("compare", in_folder("one.exr"), in_folder("two.exr"), "--json", NULL),
                  "\"variance\": 0.75,");
    assert_prints(run("compare", in_folder("one.exr"), in_folder("one.exr"), "--json", "--diff",
                      in_folder("diff.exr"), NULL),
                  "\"rmse\": 0,");

    float *rgb = NULL;
    uint32_t width = 0;
    uint32_t height = 0;
    assert_int_equal(image_read_rgb(&rgb, &width, &height, in_folder("diff.exr")), STATUS_OK);
    assert_true(rgb[0] == 0.0f && width == 4 && height == 1);
    free(rgb);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(help_and_version_go_to_stdout),
        TEST(wrong_usage_is_2),
        TEST(bad_input_is_3),
        TEST(what_cannot_be_written_is_6_before_the_scene_is_read),
        TEST(compare_tells_the_difference),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
