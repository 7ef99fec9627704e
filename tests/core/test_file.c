// File replacement: whole or not at all.

#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <setjmp.h>
#include <cmocka.h>

#include <dirent.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include "core/file.h"
#include "folder.h"

static int entry_count(void)
{
    int count = -2; // . and ..
    DIR *entries = opendir(folder);
    assert_non_null(entries);
    while (readdir(entries) != NULL)
        count++;
    closedir(entries);
    return count;
}

static void assert_holds(const char *path, const char *text)
{
    char *bytes = NULL;
    size_t size = 0;
    assert_int_equal(file_read(&bytes, &size, path), STATUS_OK);
    assert_int_equal(size, strlen(text));
    assert_string_equal(bytes, text);
    free(bytes);
}

static void file_reads_what_was_written(void **state)
{
    (void)state;
    // Any bytes, larger than the first guess of a pipe's size.
    const size_t size = 300001;
    char *written = malloc(size);
    assert_non_null(written);
    for (size_t i = 0; i < size; i++)
        written[i] = (char)(i * 31 + i / 256);
    assert_int_equal(file_write(in_folder("a"), written, size), STATUS_OK);

    char *bytes = NULL;
    size_t read_size = 0;
    assert_int_equal(file_read(&bytes, &read_size, in_folder("a")), STATUS_OK);
    assert_int_equal(read_size, size);
    assert_memory_equal(bytes, written, size);
    assert_int_equal(bytes[size], 0);
    free(bytes);
    free(written);
    assert_int_equal(entry_count(), 1);
}

static void file_of_no_bytes_is_empty_text(void **state)
{
    (void)state;
    assert_int_equal(file_write(in_folder("a"), NULL, 0), STATUS_OK);
    assert_holds(in_folder("a"), "");
}

static void file_that_is_absent_is_named(void **state)
{
    (void)state;
    char *bytes = NULL;
    size_t size = 0;
    assert_int_equal(file_read(&bytes, &size, in_folder("none")), STATUS_IO);
    assert_non_null(strstr(status_message(), "none"));
    assert_null(bytes);
    assert_int_equal(file_read(&bytes, &size, folder), STATUS_IO);
}

static void full_disk_leaves_the_old_file(void **state)
{
    (void)state;
    assert_int_equal(file_write(in_folder("a"), "old", 3), STATUS_OK);

    // A limit on the size of files stands in for a disk that fills up.
    signal(SIGXFSZ, SIG_IGN);
    struct rlimit before;
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    struct rlimit small = before;
    small.rlim_cur = 1000;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &small), 0);
    char bytes[5000] = {1};
    const enum status status = file_write(in_folder("a"), bytes, sizeof(bytes));
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);

    assert_int_equal(status, STATUS_WRITE);
    assert_holds(in_folder("a"), "old");
    assert_int_equal(entry_count(), 1);
}

static void full_device_is_told(void **state)
{
    (void)state;
    if (access("/dev/full", W_OK) != 0)
        skip();
    assert_int_equal(file_write("/dev/full", "text", 4), STATUS_WRITE);
    assert_int_equal(file_write("/dev/null", "text", 4), STATUS_OK);
    struct stat info;
    assert_int_equal(stat("/dev/null", &info), 0);
    assert_true(S_ISCHR(info.st_mode));
}

static void replacing_keeps_permissions_and_links(void **state)
{
    (void)state;
    assert_int_equal(file_write(in_folder("a"), "old", 3), STATUS_OK);
    assert_int_equal(chmod(in_folder("a"), 0640), 0);
    assert_int_equal(symlink("a", in_folder("link")), 0);
    assert_int_equal(file_write(in_folder("link"), "new", 3), STATUS_OK);

    assert_holds(in_folder("a"), "new");
    struct stat info;
    assert_int_equal(stat(in_folder("a"), &info), 0);
    assert_int_equal(info.st_mode & 0777, 0640);
    assert_int_equal(lstat(in_folder("link"), &info), 0);
    assert_true(S_ISLNK(info.st_mode));
}

static void check_tells_what_cannot_be_written(void **state)
{
    (void)state;
    assert_int_equal(file_check_writable(in_folder("a")), STATUS_OK);
    assert_int_equal(entry_count(), 0);
    assert_int_equal(file_check_writable(in_folder("none/a")), STATUS_WRITE);
    assert_non_null(strstr(status_message(), "does not exist"));
    assert_int_equal(file_check_writable(folder), STATUS_WRITE);
    assert_int_equal(file_check_writable(""), STATUS_WRITE);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, folder_setup, folder_teardown)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(file_reads_what_was_written),
        TEST(file_of_no_bytes_is_empty_text),
        TEST(file_that_is_absent_is_named),
        TEST(full_disk_leaves_the_old_file),
        TEST(full_device_is_told),
        TEST(replacing_keeps_permissions_and_links),
        TEST(check_tells_what_cannot_be_written),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
