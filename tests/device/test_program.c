// Building programs: errors say what the compiler said, and no state of the cache is an error.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "core/file.h"
#include "device/build_cache.h"
#include "folder.h"
#include "support.h"

#define PATH_SIZE 1024

static const char good_text[] =
    "__kernel __attribute__((reqd_work_group_size(4, 1, 1))) void answer(__global uint *out)\n"
    "{\n"
    "    out[get_global_id(0)] = 42;\n"
    "}\n";
static const char other_text[] =
    "__kernel __attribute__((reqd_work_group_size(4, 1, 1))) void answer(__global uint *out)\n"
    "{\n"
    "    out[get_global_id(0)] = 43;\n"
    "}\n";

static const struct program_options no_options;

static enum status build(struct program *out, const struct gpu *gpu, const char *text)
{
    return program_build_text(out, gpu, text, strlen(text), &no_options);
}

// What the program's kernel answers.
static uint32_t ask(struct gpu *gpu, const struct program *program)
{
    uint32_t answer = 0;
    struct buffer out = device_buffer(gpu, NULL, 4 * sizeof(uint32_t));
    const struct kernel_arg args[] = {ARG_BUFFER(&out)};
    DEVICE_RUN(gpu, program, "answer", args, 1);
    assert_ok(buffer_read(gpu, &out, &answer, sizeof(answer)));
    buffer_free(gpu, &out);
    return answer;
}

// The path of the one file in the cache; "" if there is none.
static void find_file(char *path)
{
    DIR *dir = opendir(folder);
    assert_non_null(dir);
    path[0] = '\0';
    for (struct dirent *entry = readdir(dir); entry != NULL; entry = readdir(dir)) {
        if (entry->d_name[0] == '.')
            continue;
        assert_int_equal(path[0], '\0');
        snprintf(path, PATH_SIZE, "%s/%s", folder, entry->d_name);
    }
    closedir(dir);
}

static int cache_teardown(void **state)
{
    char path[PATH_SIZE];
    find_file(path);
    return folder_teardown(state);
}

// The device under another name, since builds for PoCL are not cached.
static struct gpu disguise(const struct gpu *gpu)
{
    struct gpu out = *gpu;
    snprintf(out.info.platform, sizeof(out.info.platform), "A platform for tests");
    return out;
}

// Keeps a program under a key and returns the bytes of its file; released with free().
static char *fill_cache(const struct gpu *gpu, struct build_key *key, size_t *size, char *path)
{
    const struct gpu other = disguise(gpu);
    const struct program_options options = {.no_cache = true};
    struct program program;
    char *bytes = NULL;
    assert_ok(program_build_text(&program, gpu, good_text, strlen(good_text), &options));
    assert_true(build_cache_key(key, &other, good_text, strlen(good_text), ""));
    build_cache_save(key, program.handle);
    program_free(&program);
    find_file(path);
    assert_ok(file_read(&bytes, size, path));
    return bytes;
}

static void assert_not_loaded(const struct build_key *key, const struct gpu *gpu)
{
    assert_null(build_cache_load(key, gpu, ""));
}

// ---- laws of the cache

static void keys_tell_builds_apart(void **state)
{
    const struct gpu *gpu = device_of(state);
    struct build_key keys[8];
    struct gpu others[6];
    for (int i = 0; i < 6; i++)
        others[i] = disguise(gpu);
    others[1].info.platform[0] = 'B';
    strcat(others[2].info.platform_version, "1");
    strcat(others[3].info.driver, "1");
    strcat(others[4].info.version, "1");
    strcat(others[5].info.name, "1");
    for (int i = 0; i < 6; i++)
        assert_true(build_cache_key(&keys[i], &others[i], "text", 4, "options"));
    assert_true(build_cache_key(&keys[6], &others[0], "texT", 4, "options"));
    assert_true(build_cache_key(&keys[7], &others[0], "text", 4, "optionS"));
    for (int i = 0; i < 8; i++)
        for (int j = 0; j < i; j++)
            assert_memory_not_equal(&keys[i], &keys[j], sizeof(keys[i]));

    struct build_key again;
    assert_true(build_cache_key(&again, &others[0], "text", 4, "options"));
    assert_memory_equal(&again, &keys[0], sizeof(again));
}

static void pocl_keeps_its_own_cache(void **state)
{
    struct gpu gpu = disguise(device_of(state));
    struct build_key key;
    snprintf(gpu.info.platform, sizeof(gpu.info.platform), "Portable Computing Language");
    assert_false(build_cache_key(&key, &gpu, "text", 4, ""));
}

static void what_is_kept_is_found(void **state)
{
    struct gpu *gpu = device_of(state);
    struct build_key key;
    size_t size;
    char path[PATH_SIZE];
    free(fill_cache(gpu, &key, &size, path));
    struct program program = {.handle = build_cache_load(&key, gpu, "")};
    assert_non_null(program.handle);
    assert_int_equal(ask(gpu, &program), 42);
    program_free(&program);
}

static void cut_files_are_not_believed(void **state)
{
    struct gpu *gpu = device_of(state);
    struct build_key key;
    size_t size;
    char path[PATH_SIZE];
    char *bytes = fill_cache(gpu, &key, &size, path);
    const size_t sizes[] = {0, 1, 4, 39, 40, 41, size / 2, size - 1};
    for (size_t i = 0; i < sizeof(sizes) / sizeof(sizes[0]); i++) {
        assert_ok(file_write(path, bytes, sizes[i]));
        assert_not_loaded(&key, gpu);
    }
    free(bytes);
}

static void changed_files_are_not_believed(void **state)
{
    struct gpu *gpu = device_of(state);
    struct build_key key;
    size_t size;
    char path[PATH_SIZE];
    char *bytes = fill_cache(gpu, &key, &size, path);
    char *longer = calloc(1, size + 1);
    memcpy(longer, bytes, size);
    assert_ok(file_write(path, longer, size + 1));
    assert_not_loaded(&key, gpu);
    free(longer);

    // Bytes 4 to 7 are padding.
    const size_t places[] = {0, 3, 8, 23, 24, 32, 39, 40, size / 2, size - 1};
    for (size_t i = 0; i < sizeof(places) / sizeof(places[0]); i++) {
        bytes[places[i]] ^= 1;
        assert_ok(file_write(path, bytes, size));
        assert_not_loaded(&key, gpu);
        bytes[places[i]] ^= 1;
    }
    free(bytes);
}

static void files_of_other_builds_are_not_believed(void **state)
{
    struct gpu *gpu = device_of(state);
    struct build_key key;
    size_t size;
    char path[PATH_SIZE];
    char *bytes = fill_cache(gpu, &key, &size, path);
    assert_int_equal(unlink(path), 0);

    // Another build's file under this build's name.
    struct build_key other = {{key.hash[0] + 1, key.hash[1]}};
    snprintf(path, sizeof(path), "%s/%016llx%016llx.bin", folder, (unsigned long long)other.hash[0],
             (unsigned long long)other.hash[1]);
    assert_ok(file_write(path, bytes, size));
    assert_not_loaded(&other, gpu);
    free(bytes);
}

static void a_spoilt_cache_means_a_build_from_source(void **state)
{
    struct gpu *gpu = device_of(state);
    const struct gpu other = disguise(gpu);
    char path[PATH_SIZE];
    struct program program;
    static const bool from_source[] = {true, false, true, false};
    for (int turn = 0; turn < 4; turn++) {
        if (turn == 2)
            assert_ok(file_write(path, "rubbish", 7));
        assert_ok(build(&program, &other, good_text));
        assert_int_equal(program.from_source, from_source[turn]);
        assert_int_equal(ask(gpu, &program), 42);
        program_free(&program);
        find_file(path);
    }

    // Another text is another build.
    assert_int_equal(unlink(path), 0);
    assert_ok(build(&program, &other, other_text));
    assert_true(program.from_source);
    assert_int_equal(ask(gpu, &program), 43);
    program_free(&program);
}

static void no_place_for_a_cache_is_no_error(void **state)
{
    struct gpu *gpu = device_of(state);
    const struct gpu other = disguise(gpu);
    setenv("LIGHTKILN_CACHE_DIR", "/dev/null/nowhere", 1);
    struct program program;
    assert_ok(build(&program, &other, good_text));
    assert_true(program.from_source);
    assert_int_equal(ask(gpu, &program), 42);
    program_free(&program);
}

static void the_cache_can_be_passed_by(void **state)
{
    const struct gpu other = disguise(device_of(state));
    const struct program_options options = {.no_cache = true};
    char path[PATH_SIZE];
    for (int turn = 0; turn < 2; turn++) {
        struct program program;
        assert_ok(program_build_text(&program, &other, good_text, strlen(good_text), &options));
        assert_true(program.from_source);
        program_free(&program);
        find_file(path);
        assert_string_equal(path, "");
    }
}

// ---- laws of building

static void errors_show_the_build_log(void **state)
{
    const struct gpu *gpu = device_of(state);
    struct program program = {0};
    assert_int_equal(build(&program, gpu, "__kernel void f(void) { no_such_name(); }\n"),
                     STATUS_DEVICE);
    assert_non_null(strstr(status_message(), "no_such_name"));
    assert_non_null(strstr(status_message(), "-cl-std=CL1.2"));
    assert_null(program.handle);
}

static void unknown_names_are_errors(void **state)
{
    const struct gpu *gpu = device_of(state);
    struct program program = {0};
    struct kernel kernel = {0};
    assert_int_equal(program_build(&program, gpu, "nonsense", &no_options), STATUS_DEVICE);
    assert_non_null(strstr(status_message(), "nonsense"));
    assert_ok(build(&program, gpu, good_text));
    assert_int_equal(kernel_create(&kernel, gpu, &program, "question"), STATUS_DEVICE);
    assert_non_null(strstr(status_message(), "question"));
    program_free(&program);
}

static void kernels_say_their_group_size(void **state)
{
    const struct gpu *gpu = device_of(state);
    struct program program;
    struct kernel kernel = {0};
    assert_ok(build(&program, gpu, good_text));
    assert_ok(kernel_create(&kernel, gpu, &program, "answer"));
    assert_int_equal(kernel.group_size, 4);
    assert_string_equal(kernel.name, "answer");
    kernel_free(&kernel);
    program_free(&program);
    assert_ok(build(&program, gpu, "__kernel void mute(__global uint *out) { out[0] = 1; }\n"));
    assert_int_equal(kernel_create(&kernel, gpu, &program, "mute"), STATUS_DEVICE);
    program_free(&program);
}

int main(void)
{
#define CACHE_TEST(name) cmocka_unit_test_setup_teardown(name, folder_setup_cache, cache_teardown)
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(keys_tell_builds_apart),
        cmocka_unit_test(pocl_keeps_its_own_cache),
        CACHE_TEST(what_is_kept_is_found),
        CACHE_TEST(cut_files_are_not_believed),
        CACHE_TEST(changed_files_are_not_believed),
        CACHE_TEST(files_of_other_builds_are_not_believed),
        CACHE_TEST(a_spoilt_cache_means_a_build_from_source),
        CACHE_TEST(no_place_for_a_cache_is_no_error),
        CACHE_TEST(the_cache_can_be_passed_by),
        cmocka_unit_test(errors_show_the_build_log),
        cmocka_unit_test(unknown_names_are_errors),
        cmocka_unit_test(kernels_say_their_group_size),
    };
    return cmocka_run_group_tests(tests, device_setup, device_teardown);
}
