/**
 * @file
 * The kernels' text, one entry for each cl/NAME.cl, with every include expanded: scripts/embed_cl
 * writes it while building, so nothing is looked for at run time.
 */
#ifndef DEVICE_CL_SOURCES_H
#define DEVICE_CL_SOURCES_H

#include <stddef.h>

struct cl_source {
    const char *name; // file name without ".cl"
    const char *text; // ends with a NUL
    size_t size;      // bytes of text, without the NUL
};

/** [cl_source_count], in the order of the names. */
extern const struct cl_source cl_sources[];
extern const size_t cl_source_count;

#endif
