#include "device/gpu.h"

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <time.h>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "core/clock.h"
#include "core/log.h"
#include "device/profile.h"

#define PLATFORM_MAX 16 // platforms looked at
#define DEVICE_MAX   32 // devices looked at on each

// Reads a text of a device; "" if it has none.
static void device_text(cl_device_id device, cl_device_info what, char *out, size_t size)
{
    out[0] = '\0';
    char text[1024] = "";
    if (clGetDeviceInfo(device, what, sizeof(text), text, NULL) != CL_SUCCESS)
        return;
    text[sizeof(text) - 1] = '\0';
    const char *start = text;
    while (isspace((unsigned char)*start))
        start++;
    snprintf(out, size, "%.*s", (int)size - 1, start);
}

static uint64_t device_size(cl_device_id device, cl_device_info what, size_t size)
{
    uint64_t value = 0; // little-endian hosts alone: a shorter number fills the low bytes
    clGetDeviceInfo(device, what, size, &value, NULL);
    return value;
}

static void find_reason(struct gpu_info *out, cl_device_id device)
{
    int major = 0;
    int minor = 0;
    sscanf(out->version, "OpenCL %d.%d", &major, &minor);
    out->usable = false;
    if (major * 10 + minor < 12)
        snprintf(out->reason, sizeof(out->reason), "needs OpenCL 1.2, has \"%.80s\"", out->version);
    else if (!device_size(device, CL_DEVICE_AVAILABLE, sizeof(cl_bool)))
        snprintf(out->reason, sizeof(out->reason), "is not available");
    else if (!device_size(device, CL_DEVICE_COMPILER_AVAILABLE, sizeof(cl_bool)))
        snprintf(out->reason, sizeof(out->reason), "has no compiler");
    else if (!device_size(device, CL_DEVICE_ENDIAN_LITTLE, sizeof(cl_bool)))
        snprintf(out->reason, sizeof(out->reason), "is big-endian");
    else
        out->usable = true;
}

static void describe(struct gpu_info *out, cl_platform_id platform, cl_device_id device)
{
    memset(out, 0, sizeof(*out));
    clGetPlatformInfo(platform, CL_PLATFORM_NAME, sizeof(out->platform) - 1, out->platform, NULL);
    clGetPlatformInfo(platform, CL_PLATFORM_VERSION, sizeof(out->platform_version) - 1,
                      out->platform_version, NULL);
    device_text(device, CL_DEVICE_NAME, out->name, sizeof(out->name));
    device_text(device, CL_DRIVER_VERSION, out->driver, sizeof(out->driver));
    device_text(device, CL_DEVICE_VERSION, out->version, sizeof(out->version));

    const uint64_t type = device_size(device, CL_DEVICE_TYPE, sizeof(cl_device_type));
    const char *name = type & CL_DEVICE_TYPE_CPU           ? "cpu"
                       : type & CL_DEVICE_TYPE_GPU         ? "gpu"
                       : type & CL_DEVICE_TYPE_ACCELERATOR ? "accelerator"
                                                           : "custom";
    snprintf(out->type, sizeof(out->type), "%s", name);
    out->is_cpu = (type & CL_DEVICE_TYPE_CPU) != 0;
    out->compute_units =
        (uint32_t)device_size(device, CL_DEVICE_MAX_COMPUTE_UNITS, sizeof(cl_uint));
    out->global_memory = device_size(device, CL_DEVICE_GLOBAL_MEM_SIZE, sizeof(cl_ulong));
    out->max_allocation = device_size(device, CL_DEVICE_MAX_MEM_ALLOC_SIZE, sizeof(cl_ulong));
    out->local_memory = device_size(device, CL_DEVICE_LOCAL_MEM_SIZE, sizeof(cl_ulong));
    out->has_images = device_size(device, CL_DEVICE_IMAGE_SUPPORT, sizeof(cl_bool)) != 0;
    out->image1d_max = device_size(device, CL_DEVICE_IMAGE_MAX_BUFFER_SIZE, sizeof(size_t));
    find_reason(out, device);
}

// One device on one platform.
struct candidate {
    struct gpu_info info;
    bool taken; // by a word of the list
};

// Finds every device; returns how many, at most `max`.
static size_t find_all(struct candidate *out, size_t max)
{
    cl_platform_id platforms[PLATFORM_MAX];
    cl_uint platform_count = 0;
    if (clGetPlatformIDs(PLATFORM_MAX, platforms, &platform_count) != CL_SUCCESS)
        return 0;
    if (platform_count > PLATFORM_MAX)
        platform_count = PLATFORM_MAX;

    size_t count = 0;
    for (cl_uint p = 0; p < platform_count; p++) {
        cl_device_id devices[DEVICE_MAX];
        cl_uint device_count = 0;
        if (clGetDeviceIDs(platforms[p], CL_DEVICE_TYPE_ALL, DEVICE_MAX, devices, &device_count) !=
            CL_SUCCESS)
            continue;
        if (device_count > DEVICE_MAX)
            device_count = DEVICE_MAX;
        for (cl_uint d = 0; d < device_count && count < max; d++) {
            struct candidate *found = &out[count++];
            describe(&found->info, platforms[p], devices[d]);
            found->info.platform_index = p;
            found->info.device_index = d;
        }
    }
    return count;
}

enum status gpu_describe(struct gpu_info *out, size_t index)
{
    struct candidate *found = calloc(PLATFORM_MAX * DEVICE_MAX, sizeof(*found));
    if (found == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to list devices");
    const size_t count = find_all(found, PLATFORM_MAX * DEVICE_MAX);
    enum status status = STATUS_OK;
    if (index < count)
        *out = found[index].info;
    else
        status = status_fail(STATUS_NO_DEVICE,
                             count == 0 ? "there is no OpenCL device; install a driver, or "
                                          "pocl-opencl-icd to render on the CPU"
                                        : "there are only %zu OpenCL devices",
                             count);
    free(found);
    return status;
}

static bool contains(const char *text, const char *part)
{
    return strcasestr(text, part) != NULL;
}

static bool matches(const struct gpu_info *info, const char *selector)
{
    if (strcmp(selector, "best") == 0 || strcmp(selector, "all") == 0)
        return true;
    if (strcmp(selector, "cpu") == 0 || strcmp(selector, "gpu") == 0)
        return strcmp(info->type, selector) == 0;
    unsigned platform = 0;
    unsigned device = 0;
    int end = 0;
    if (sscanf(selector, "%u:%u%n", &platform, &device, &end) == 2 && selector[end] == '\0')
        return info->platform_index == platform && info->device_index == device;
    return contains(info->name, selector) || contains(info->platform, selector);
}

// Orders devices by what they promise.
static uint64_t rank(const struct gpu_info *info)
{
    const uint64_t kind = strcmp(info->type, "gpu") == 0   ? 3
                          : strcmp(info->type, "cpu") == 0 ? 1
                                                           : 2;
    return kind << 32 | info->compute_units;
}

// The best of those that match and are not taken.
static struct candidate *choose(struct candidate *found, size_t count, const char *word)
{
    struct candidate *best = NULL;
    for (size_t i = 0; i < count; i++)
        if (!found[i].taken && found[i].info.usable && matches(&found[i].info, word) &&
            (best == NULL || rank(&found[i].info) > rank(&best->info)))
            best = &found[i];
    return best;
}

static enum status fail_to_choose(const struct candidate *found, size_t count, const char *word)
{
    if (count == 0)
        return status_fail(STATUS_NO_DEVICE, "there is no OpenCL device; install a driver, or "
                                             "pocl-opencl-icd to render on the CPU");
    size_t taken = 0;
    const struct candidate *unusable = NULL;
    for (size_t i = 0; i < count; i++)
        if (matches(&found[i].info, word)) {
            taken += found[i].taken;
            unusable = found[i].info.usable ? unusable : &found[i];
        }
    if (unusable != NULL)
        return status_fail(STATUS_NO_DEVICE, "device \"%s\" %s", unusable->info.name,
                           unusable->info.reason);
    char list[512] = "";
    for (size_t i = 0, used = 0; i < count && used < sizeof(list); i++)
        used += (size_t)snprintf(list + used, sizeof(list) - used, "%s%u:%u \"%s\"",
                                 i > 0 ? ", " : "", found[i].info.platform_index,
                                 found[i].info.device_index, found[i].info.name);
    return status_fail(STATUS_NO_DEVICE, "no %sdevice matches \"%s\"; there are %s",
                       taken > 0 ? "further " : "", word, list);
}

// Takes what one word of a list names.
static enum status select_word(struct gpu_info *out, size_t *taken, size_t max,
                               struct candidate *found, size_t count, const char *word)
{
    const bool all = strcmp(word, "all") == 0;
    struct candidate *best = choose(found, count, word);
    if (best == NULL)
        return all && *taken > 0 ? STATUS_OK : fail_to_choose(found, count, word);
    for (; best != NULL; best = all ? choose(found, count, word) : NULL) {
        if (*taken == max)
            return status_fail(STATUS_USAGE,
                               "\"%s\" is one more than the %zu device%s that can be "
                               "taken",
                               word, max, max == 1 ? "" : "s");
        best->taken = true;
        out[(*taken)++] = best->info;
    }
    return STATUS_OK;
}

enum status gpu_select(struct gpu_info *out, size_t *count, size_t max, const char *list)
{
    const char *at = list != NULL ? list : "best";
    size_t taken = 0;
    struct candidate *found = calloc(PLATFORM_MAX * DEVICE_MAX, sizeof(*found));
    if (found == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to list devices");
    const size_t found_count = find_all(found, PLATFORM_MAX * DEVICE_MAX);

    enum status status = STATUS_OK;
    while (status == STATUS_OK && at != NULL) {
        char word[256];
        const size_t size = strcspn(at, ",");
        snprintf(word, sizeof(word), "%.*s", (int)size, at);
        if (size == 0)
            status = status_fail(STATUS_USAGE, "a device without a name in \"%s\"", list);
        else
            status = select_word(out, &taken, max, found, found_count, word);
        at = at[size] == ',' ? at + size + 1 : NULL;
    }
    free(found);
    if (status == STATUS_OK)
        *count = taken;
    return status;
}

// Finds the device that was chosen.
static enum status find_device(struct gpu *gpu, const struct gpu_info *info)
{
    cl_platform_id platforms[PLATFORM_MAX];
    cl_device_id devices[DEVICE_MAX];
    cl_uint platform_count = 0;
    cl_uint device_count = 0;
    if (clGetPlatformIDs(PLATFORM_MAX, platforms, &platform_count) != CL_SUCCESS ||
        info->platform_index >= platform_count ||
        clGetDeviceIDs(platforms[info->platform_index], CL_DEVICE_TYPE_ALL, DEVICE_MAX, devices,
                       &device_count) != CL_SUCCESS ||
        info->device_index >= device_count)
        return status_fail(STATUS_NO_DEVICE, "device \"%s\" is gone", info->name);
    gpu->info = *info;
    gpu->platform = platforms[info->platform_index];
    gpu->device = devices[info->device_index];
    return STATUS_OK;
}

// Takes a part of the device, if it can be had. The part is never released: PoCL 3.1's threads look
// at it after the last command has ended, and crash where it is gone.
static void leave_units(struct gpu *gpu, uint32_t spare_units)
{
    const uint32_t units = gpu->info.compute_units;
    if (spare_units == 0 || units <= spare_units)
        return;
    const cl_device_partition_property properties[] = {CL_DEVICE_PARTITION_BY_COUNTS,
                                                       units - spare_units,
                                                       CL_DEVICE_PARTITION_BY_COUNTS_LIST_END, 0};
    cl_device_id part = NULL;
    if (clCreateSubDevices(gpu->device, properties, 1, &part, NULL) != CL_SUCCESS)
        return;
    gpu->device = part;
    gpu->info.compute_units = units - spare_units;
}

enum status gpu_open(struct gpu *out, const struct gpu_info *info, bool profile,
                     uint32_t spare_units)
{
    struct gpu gpu = {0};
    cl_int error = CL_SUCCESS;
    enum status status = find_device(&gpu, info);
    if (status != STATUS_OK)
        return status;
    leave_units(&gpu, spare_units);

    const cl_context_properties properties[] = {CL_CONTEXT_PLATFORM,
                                                (cl_context_properties)gpu.platform, 0};
    gpu.context = clCreateContext(properties, 1, &gpu.device, NULL, NULL, &error);
    if (error != CL_SUCCESS) {
        status = gpu_fail(error, "clCreateContext", gpu.info.name);
        goto cleanup;
    }
    gpu.queue = clCreateCommandQueue(gpu.context, gpu.device,
                                     profile ? CL_QUEUE_PROFILING_ENABLE : 0, &error);
    if (error != CL_SUCCESS) {
        status = gpu_fail(error, "clCreateCommandQueue", gpu.info.name);
        goto cleanup;
    }
    if (profile && (gpu.profile = profile_create()) == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for the profile");
        goto cleanup;
    }
    log_message(LOG_INFO, "using %s \"%s\" of %s", gpu.info.type, gpu.info.name, gpu.info.platform);
    *out = gpu;
    gpu = (struct gpu){0}; // the caller owns it now

cleanup:
    gpu_close(&gpu);
    return status;
}

void gpu_close(struct gpu *gpu)
{
    if (gpu->queue != NULL)
        clFinish(gpu->queue);
    profile_free(gpu->profile);
    if (gpu->queue != NULL)
        clReleaseCommandQueue(gpu->queue);
    if (gpu->context != NULL)
        clReleaseContext(gpu->context);
    *gpu = (struct gpu){0};
}

// Between looks at an event. Short beside a batch; each look takes some microseconds.
#define LOOK_EVERY_NS 30000

enum status gpu_wait(struct gpu *gpu)
{
    // PoCL sleeps by itself, and is woken at once.
    if (gpu->info.is_cpu) {
        const cl_int error = clFinish(gpu->queue);
        return error == CL_SUCCESS ? STATUS_OK : gpu_fail(error, "clFinish", gpu->info.name);
    }
    bool done;
    return gpu_wait_until(gpu, INFINITY, &done);
}

enum status gpu_wait_until(struct gpu *gpu, double limit_s, bool *done)
{
    const double end_s = clock_seconds() + limit_s;
    cl_event end = NULL;
    cl_int error = clEnqueueMarkerWithWaitList(gpu->queue, 0, NULL, &end);
    if (error == CL_SUCCESS)
        error = clFlush(gpu->queue);
    cl_int state = CL_QUEUED;
    const int slack_ns = prctl(PR_GET_TIMERSLACK);
    prctl(PR_SET_TIMERSLACK, 1); // sleep no longer than is asked for
    while (error == CL_SUCCESS && state > CL_COMPLETE && clock_seconds() <= end_s) {
        nanosleep(&(const struct timespec){.tv_nsec = LOOK_EVERY_NS}, NULL);
        error = clGetEventInfo(end, CL_EVENT_COMMAND_EXECUTION_STATUS, sizeof(state), &state, NULL);
    }
    prctl(PR_SET_TIMERSLACK, slack_ns);
    if (end != NULL)
        clReleaseEvent(end);
    if (error == CL_SUCCESS && state < 0)
        error = state;
    *done = error != CL_SUCCESS || state == CL_COMPLETE;
    return error == CL_SUCCESS ? STATUS_OK : gpu_fail(error, "waiting", gpu->info.name);
}

enum status gpu_open_timed(struct gpu *out, const struct gpu *gpu)
{
    cl_int error = CL_SUCCESS;
    struct gpu timed = *gpu;
    timed.profile = profile_create();
    if (timed.profile == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for the profile");
    timed.queue =
        clCreateCommandQueue(gpu->context, gpu->device, CL_QUEUE_PROFILING_ENABLE, &error);
    if (error != CL_SUCCESS) {
        profile_free(timed.profile);
        return gpu_fail(error, "clCreateCommandQueue", gpu->info.name);
    }
    *out = timed;
    return STATUS_OK;
}

void gpu_close_timed(struct gpu *timed)
{
    timed->context = NULL; // the device's
    gpu_close(timed);
}

enum status gpu_flush(struct gpu *gpu)
{
    const cl_int error = clFlush(gpu->queue);
    return error == CL_SUCCESS ? STATUS_OK : gpu_fail(error, "clFlush", gpu->info.name);
}

size_t gpu_profile(const struct gpu *gpu, struct profile_entry *out, size_t max)
{
    if (gpu->profile == NULL)
        return 0;
    profile_collect(gpu->profile);
    return profile_read(gpu->profile, out, max);
}
