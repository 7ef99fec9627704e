#include "folder.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

char folder[64];

int folder_setup(void **state)
{
    (void)state;
    strcpy(folder, "/tmp/lightkiln-test-XXXXXX");
    return mkdtemp(folder) != NULL ? 0 : -1;
}

int folder_teardown(void **state)
{
    (void)state;
    char command[128];
    snprintf(command, sizeof(command), "rm -rf '%s'", folder);
    return system(command);
}

const char *in_folder(const char *name)
{
    static char paths[8][512];
    static int next;
    char *path = paths[next++ % 8];
    snprintf(path, sizeof(paths[0]), "%s/%s", folder, name);
    return path;
}
