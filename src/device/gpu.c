#include "device/gpu.h"

#include <ctype.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

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
    cl_platform_id platform;
    cl_device_id device;
    struct gpu_info info;
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
            found->platform = platforms[p];
            found->device = devices[d];
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
    if (selector == NULL || strcmp(selector, "best") == 0)
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

static const struct candidate *choose(const struct candidate *found, size_t count,
                                      const char *selector, const struct candidate **unusable)
{
    const struct candidate *best = NULL;
    for (size_t i = 0; i < count; i++) {
        if (!matches(&found[i].info, selector))
            continue;
        if (!found[i].info.usable)
            *unusable = &found[i];
        else if (best == NULL || rank(&found[i].info) > rank(&best->info))
            best = &found[i];
    }
    return best;
}

static enum status fail_to_choose(const struct candidate *found, size_t count, const char *selector,
                                  const struct candidate *unusable)
{
    if (count == 0)
        return status_fail(STATUS_NO_DEVICE, "there is no OpenCL device; install a driver, or "
                                             "pocl-opencl-icd to render on the CPU");
    if (unusable != NULL)
        return status_fail(STATUS_NO_DEVICE, "device \"%s\" %s", unusable->info.name,
                           unusable->info.reason);
    char list[512] = "";
    for (size_t i = 0, used = 0; i < count && used < sizeof(list); i++)
        used += (size_t)snprintf(list + used, sizeof(list) - used, "%s%u:%u \"%s\"",
                                 i > 0 ? ", " : "", found[i].info.platform_index,
                                 found[i].info.device_index, found[i].info.name);
    return status_fail(STATUS_NO_DEVICE, "no device matches \"%s\"; there are %s", selector, list);
}

enum status gpu_open(struct gpu *out, const char *selector, bool profile)
{
    enum status status = STATUS_OK;
    struct gpu gpu = {0};
    cl_int error = CL_SUCCESS;
    struct candidate *found = calloc(PLATFORM_MAX * DEVICE_MAX, sizeof(*found));
    if (found == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory to list devices");

    const size_t count = find_all(found, PLATFORM_MAX * DEVICE_MAX);
    const struct candidate *unusable = NULL;
    const struct candidate *best = choose(found, count, selector, &unusable);
    if (best == NULL) {
        status = fail_to_choose(found, count, selector, unusable);
        goto cleanup;
    }
    gpu.info = best->info;
    gpu.platform = best->platform;
    gpu.device = best->device;

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
    free(found);
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
