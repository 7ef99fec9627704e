/**
 * @file
 * A folder of a test's own: empty when the test starts, gone when it ends.
 */
#ifndef TESTS_FOLDER_H
#define TESTS_FOLDER_H

/** Its path, between folder_setup() and folder_teardown(). */
extern char folder[64];

/** Makes it, as cmocka's setup. */
int folder_setup(void **state);

/** Removes it with all that is in it. */
int folder_teardown(void **state);

/** The path of what has this name in it: eight stay valid at a time. */
const char *in_folder(const char *name);

#endif
