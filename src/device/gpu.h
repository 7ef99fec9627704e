/**
 * @file
 * OpenCL devices: what there is, choosing one, and the one context and queue that a render uses.
 *
 * Only this folder sees CL/cl.h. Handles appear in its headers as pointers to OpenCL's own opaque
 * structs, so that they are passed on but not used elsewhere.
 */
#ifndef DEVICE_GPU_H
#define DEVICE_GPU_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/status.h"

/** What a device says of itself. */
struct gpu_info {
    char platform[128], platform_version[128];
    char name[128], driver[128], version[128];
    char type[16]; // "cpu", "gpu", "accelerator", "custom"
    uint32_t platform_index, device_index;
    uint32_t compute_units;
    uint64_t global_memory, max_allocation, local_memory; // bytes
    bool is_cpu;
    bool has_images;
    uint64_t image1d_max; // texels of an image1d_buffer_t
    bool usable;          // OpenCL 1.2 with a compiler
    char reason[128];     // if not: why
};

/** An opened device. All zero is a valid closed one. */
struct gpu {
    struct gpu_info info;
    struct _cl_platform_id *platform;
    struct _cl_device_id *device;    // or a part of it
    struct _cl_context *context;     // owned
    struct _cl_command_queue *queue; // in order; owned
    struct profile *profile;         // NULL: kernels are not timed; owned
    uint64_t allocated;              // bytes in buffers and images now
};

/** Time spent in one kernel. */
struct profile_entry {
    char name[32];
    uint64_t calls;
    double time_s;
};

/**
 * Describes device `index`, counted over all platforms.
 *
 * @retval STATUS_NO_DEVICE  There is no such device.
 */
enum status gpu_describe(struct gpu_info *out, size_t index);

/**
 * Chooses devices.
 *
 * @param[out] out    [max], in the order in which they are named; never one twice.
 * @param[out] count  1 .. max.
 * @param list        NULL: the best (a GPU before an accelerator before a CPU, then by compute
 * units). Else words with commas between, each taking the best device that matches and is not
 * taken: "best"; "cpu", "gpu"; "P:D"; part of a device's or platform's name, in any case. "all"
 * takes every usable one that is left.
 * @retval STATUS_NO_DEVICE  For some word none is left that matches, or the one that does cannot be
 * used; says which there are.
 * @retval STATUS_USAGE      A word is empty, or more than `max` are asked for.
 */
enum status gpu_select(struct gpu_info *out, size_t *count, size_t max, const char *list);

/**
 * Opens a device.
 *
 * @param info         What gpu_select() has chosen.
 * @param profile      Time every kernel.
 * @param spare_units  Compute units to leave alone, if the device has more and can be parted.
 * @retval STATUS_DEVICE  It cannot be opened.
 */
enum status gpu_open(struct gpu *out, const struct gpu_info *info, bool profile,
                     uint32_t spare_units);

/** Waits for the queue and closes. Safe on a closed one. */
void gpu_close(struct gpu *gpu);

/** Waits until the queue is empty: asleep, where a driver would have the host's core spin. */
enum status gpu_wait(struct gpu *gpu);

/** Waits for the queue as gpu_wait(), but no longer than so many seconds. @param[out] done  It is
 * empty. */
enum status gpu_wait_until(struct gpu *gpu, double limit_s, bool *done);

/**
 * Makes another queue to an opened device, in which every kernel is timed.
 *
 * @param[out] out  Close with gpu_close_timed(), before the device; buffers and kernels of the one
 * serve the other.
 */
enum status gpu_open_timed(struct gpu *out, const struct gpu *gpu);

void gpu_close_timed(struct gpu *timed);

/** Sends what is queued to the device. */
enum status gpu_flush(struct gpu *gpu);

/** The times of all kernels since gpu_open(), after a blocking read. @return entries written, at
 * most `max`. */
size_t gpu_profile(const struct gpu *gpu, struct profile_entry *out, size_t max);

/** The name of an OpenCL error, "CL_OUT_OF_RESOURCES". */
const char *gpu_error_name(int error);

/** Turns an OpenCL error into a status with a message "CALL (what): NAME". */
enum status gpu_fail(int error, const char *call, const char *what);

#endif
