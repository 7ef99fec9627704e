#include "core/file.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum status fail_no_memory(const char *path)
{
    return status_fail(STATUS_NO_MEMORY, "%s: not enough memory", path);
}

static enum status fail_write(const char *path, int error)
{
    return status_fail(STATUS_WRITE, "%s: cannot write: %s", path, strerror(error));
}

// Reads to the end. The array starts at the file's size, where it has one, and doubles.
static enum status read_all(char **bytes, size_t *size, int file, const char *path)
{
    struct stat info;
    const bool sized = fstat(file, &info) == 0 && S_ISREG(info.st_mode) && info.st_size > 0;
    size_t capacity = sized ? (size_t)info.st_size + 1 : 65536;
    size_t used = 0;
    char *data = malloc(capacity);
    if (data == NULL)
        return fail_no_memory(path);

    for (;;) {
        // Keep a place for the NUL.
        if (used + 1 == capacity) {
            char *larger = capacity > SIZE_MAX / 2 ? NULL : realloc(data, capacity * 2);
            if (larger == NULL) {
                free(data);
                return fail_no_memory(path);
            }
            data = larger;
            capacity *= 2;
        }
        const ssize_t count = read(file, data + used, capacity - used - 1);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0) {
            const int error = errno;
            free(data);
            return status_fail(STATUS_IO, "%s: cannot read: %s", path, strerror(error));
        }
        if (count == 0)
            break;
        used += (size_t)count;
    }

    data[used] = '\0';
    *bytes = data;
    *size = used;
    return STATUS_OK;
}

enum status file_read(char **bytes, size_t *size, const char *path)
{
    if (strcmp(path, "-") == 0)
        return read_all(bytes, size, STDIN_FILENO, "standard input");

    const int file = open(path, O_RDONLY | O_CLOEXEC);
    if (file < 0)
        return status_fail(STATUS_IO, "%s: cannot open: %s", path, strerror(errno));
    const enum status status = read_all(bytes, size, file, path);
    close(file);
    return status;
}

static enum status write_all(int file, const char *bytes, size_t size, const char *path)
{
    while (size > 0) {
        const ssize_t count = write(file, bytes, size);
        if (count < 0 && errno == EINTR)
            continue;
        if (count < 0)
            return fail_write(path, errno);
        bytes += count;
        size -= (size_t)count;
    }
    return STATUS_OK;
}

// Writes to what is no regular file.
static enum status write_in_place(const char *path, const void *bytes, size_t size)
{
    const int file = open(path, O_WRONLY | O_CLOEXEC);
    if (file < 0)
        return fail_write(path, errno);
    enum status status = write_all(file, bytes, size, path);
    if (close(file) != 0 && status == STATUS_OK)
        status = fail_write(path, errno);
    return status;
}

// Is there something that cannot be renamed over?
static bool is_special(const char *path)
{
    struct stat info;
    return stat(path, &info) == 0 && !S_ISREG(info.st_mode) && !S_ISDIR(info.st_mode);
}

// A file that is being replaced.
struct replacement {
    char *target;    // the file to be, symbolic links followed; owned
    char *temporary; // being written, in the same folder; NULL once it has become the target; owned
};

// Names a new file beside `target`, and makes it.
static enum status make_temporary(char **out, const char *target, mode_t mode, const char *path)
{
    static atomic_uint serial;
    const char *slash = strrchr(target, '/');
    const int folder_length = slash != NULL ? (int)(slash - target + 1) : 0;

    // A name may be left over from a killed process with our number: try the next.
    for (int attempt = 0; attempt < 100; attempt++) {
        char *name = NULL;
        if (asprintf(&name, "%.*s.lightkiln-%ld-%u.tmp", folder_length, target, (long)getpid(),
                     atomic_fetch_add(&serial, 1)) < 0)
            return fail_no_memory(path);

        const int file = open(name, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0) {
            // Keep the old file's permissions; a new one has those that the umask leaves.
            if (mode != 0 && fchmod(file, mode) != 0) {
                // Some file systems know no permissions; the file is as good without.
            }
            close(file);
            *out = name;
            return STATUS_OK;
        }
        const int error = errno;
        free(name);
        if (error == ENOENT)
            return status_fail(STATUS_WRITE, "%s: the folder %.*s does not exist; make it first",
                               path, folder_length, target);
        if (error != EEXIST)
            return fail_write(path, error);
    }
    return fail_write(path, EEXIST);
}

// Makes the empty temporary of a file that is to be replaced.
static enum status replace_begin(struct replacement *out, const char *path)
{
    if (path[0] == '\0')
        return status_fail(STATUS_WRITE, "a file name is empty");

    struct stat info;
    const bool exists = stat(path, &info) == 0;
    if (exists && S_ISDIR(info.st_mode))
        return status_fail(STATUS_WRITE, "%s: is a folder; name a file in it", path);
    if (exists && access(path, W_OK) != 0)
        return fail_write(path, errno);

    // Renaming over a symbolic link would replace the link: follow it.
    struct replacement made = {0};
    made.target = exists ? realpath(path, NULL) : strdup(path);
    if (made.target == NULL)
        return exists && errno != ENOMEM ? fail_write(path, errno) : fail_no_memory(path);

    const mode_t mode = exists ? info.st_mode & 0777 : 0;
    const enum status status = make_temporary(&made.temporary, made.target, mode, path);
    if (status != STATUS_OK) {
        free(made.target);
        return status;
    }
    *out = made;
    return STATUS_OK;
}

// Removes the temporary if it was not renamed, and releases the names.
static void replace_end(struct replacement *replacement)
{
    if (replacement->temporary != NULL)
        unlink(replacement->temporary);
    free(replacement->temporary);
    free(replacement->target);
    *replacement = (struct replacement){0};
}

enum status file_write(const char *path, const void *bytes, size_t size)
{
    if (is_special(path))
        return write_in_place(path, bytes, size);

    struct replacement replacement = {0};
    enum status status = replace_begin(&replacement, path);
    if (status != STATUS_OK)
        return status;

    // Some file systems find out only at the sync or the close that they are full.
    const int file = open(replacement.temporary, O_WRONLY | O_CLOEXEC);
    if (file < 0) {
        status = fail_write(path, errno);
        goto cleanup;
    }
    status = write_all(file, bytes, size, path);
    if (status == STATUS_OK && fsync(file) != 0 && errno != EINVAL && errno != ENOTSUP)
        status = fail_write(path, errno);
    if (close(file) != 0 && status == STATUS_OK)
        status = fail_write(path, errno);
    if (status != STATUS_OK)
        goto cleanup;

    if (rename(replacement.temporary, replacement.target) != 0) {
        status = fail_write(path, errno);
        goto cleanup;
    }
    free(replacement.temporary);
    replacement.temporary = NULL; // it is the target now

cleanup:
    replace_end(&replacement);
    return status;
}

enum status file_check_writable(const char *path)
{
    if (is_special(path))
        return access(path, W_OK) == 0 ? STATUS_OK : fail_write(path, errno);

    struct replacement replacement = {0};
    const enum status status = replace_begin(&replacement, path);
    replace_end(&replacement);
    return status;
}
