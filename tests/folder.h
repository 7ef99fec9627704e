/**
 * @file
 * A folder of a test's own: empty when the test starts, gone when it ends.
 */
#ifndef TESTS_FOLDER_H
#define TESTS_FOLDER_H

/** Its path, between folder_setup() and folder_teardown(). */
extern char folder[512];

/** Makes it, in TMPDIR or /tmp, as cmocka's setup. */
int folder_setup(void **state);

/** The same, and lightkiln's cache is in it. */
int folder_setup_cache(void **state);

/** Removes the files in it. */
void folder_empty(void);

/** Removes it with its files; fails if something else was left in it, such as a temporary. */
int folder_teardown(void **state);

/** The path of what has this name in it: eight stay valid at a time. */
const char *in_folder(const char *name);

#endif
