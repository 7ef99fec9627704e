#include "device/profile.h"

#include <stdlib.h>
#include <string.h>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#define ENTRY_MAX   64   // kernels told apart
#define PENDING_MAX 4096 // launches whose times are not read yet; past it they are waited for

struct pending {
    cl_event event; // owned
    size_t entry;
};

struct profile {
    struct profile_entry entries[ENTRY_MAX];
    size_t entry_count;
    struct pending pending[PENDING_MAX];
    size_t pending_count;
};

struct profile *profile_create(void)
{
    return calloc(1, sizeof(struct profile));
}

static size_t find_entry(struct profile *profile, const char *name)
{
    for (size_t i = 0; i < profile->entry_count; i++)
        if (strcmp(profile->entries[i].name, name) == 0)
            return i;
    if (profile->entry_count == ENTRY_MAX)
        return ENTRY_MAX - 1;
    struct profile_entry *entry = &profile->entries[profile->entry_count];
    strncpy(entry->name, name, sizeof(entry->name) - 1);
    return profile->entry_count++;
}

void profile_add(struct profile *profile, const char *name, struct _cl_event *event)
{
    if (profile->pending_count == PENDING_MAX)
        profile_collect(profile);
    struct pending *pending = &profile->pending[profile->pending_count++];
    pending->event = event;
    pending->entry = find_entry(profile, name);
    profile->entries[pending->entry].calls++;
}

void profile_collect(struct profile *profile)
{
    for (size_t i = 0; i < profile->pending_count; i++) {
        const struct pending *pending = &profile->pending[i];
        cl_ulong start = 0;
        cl_ulong end = 0;
        clWaitForEvents(1, &pending->event);
        clGetEventProfilingInfo(pending->event, CL_PROFILING_COMMAND_START, sizeof(start), &start,
                                NULL);
        clGetEventProfilingInfo(pending->event, CL_PROFILING_COMMAND_END, sizeof(end), &end, NULL);
        if (end > start)
            profile->entries[pending->entry].time_s += (double)(end - start) * 1e-9;
        clReleaseEvent(pending->event);
    }
    profile->pending_count = 0;
}

size_t profile_read(const struct profile *profile, struct profile_entry *out, size_t max)
{
    const size_t count = profile->entry_count < max ? profile->entry_count : max;
    memcpy(out, profile->entries, count * sizeof(*out));
    return count;
}

void profile_free(struct profile *profile)
{
    if (profile == NULL)
        return;
    profile_collect(profile);
    free(profile);
}
