/**
 * @file
 * Files: read whole, written whole or not at all.
 *
 * A file is replaced by writing a temporary beside it and renaming that over it, so that a reader,
 * a crash or a full disk never meets half a file, and the old one stays until the new one is
 * complete. What is no regular file (a terminal, a pipe) is written in place.
 */
#ifndef CORE_FILE_H
#define CORE_FILE_H

#include <stddef.h>

#include "core/status.h"

/**
 * Reads a whole file.
 *
 * @param[out] bytes  [size] and a NUL that is not counted; to be released with free().
 * @param[out] size   Bytes read.
 * @param path        A file, or "-" for standard input.
 * @retval STATUS_IO         It cannot be opened or read.
 * @retval STATUS_NO_MEMORY  It does not fit.
 */
enum status file_read(char **bytes, size_t *size, const char *path);

/**
 * Writes a whole file.
 *
 * @retval STATUS_WRITE      It cannot be written; an old file is left alone.
 * @retval STATUS_NO_MEMORY  The name does not fit.
 */
enum status file_write(const char *path, const void *bytes, size_t size);

/** Checks that file_write() may write there, by making a temporary. STATUS_WRITE if not. */
enum status file_check_writable(const char *path);

#endif
