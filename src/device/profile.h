/**
 * @file
 * Kernel times from OpenCL's event timestamps; used within this folder.
 */
#ifndef DEVICE_PROFILE_H
#define DEVICE_PROFILE_H

#include "device/gpu.h"

struct _cl_event;

/** Makes an empty profile; NULL if there is not enough memory. */
struct profile *profile_create(void);

/** Takes over an event of one launch of a kernel. */
void profile_add(struct profile *profile, const char *name, struct _cl_event *event);

/** Reads the times of the finished launches and lets their events go. */
void profile_collect(struct profile *profile);

/** Copies the sums out, in order of first use. @return entries written, at most `max`. */
size_t profile_read(const struct profile *profile, struct profile_entry *out, size_t max);

void profile_free(struct profile *profile);

#endif
