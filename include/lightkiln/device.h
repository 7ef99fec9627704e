/**
 * @file
 * The OpenCL devices of this machine.
 */
#ifndef LIGHTKILN_DEVICE_H
#define LIGHTKILN_DEVICE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "lightkiln/status.h"

#ifdef __cplusplus
extern "C" {
#endif

/** One OpenCL device, usable or not. */
struct lk_device_info {
    char platform[128];
    char name[128];
    char driver[128];
    char version[128];                     // what the device says of its OpenCL
    char type[16];                         // "cpu", "gpu", "accelerator", "custom"
    uint32_t platform_index, device_index; // the P:D of --device
    uint32_t compute_units;
    uint64_t global_memory, max_allocation, local_memory; // bytes
    bool usable;                                          // OpenCL 1.2 with a compiler
    char reason[128];                                     // if not usable: why
};

/**
 * Describes device `index` of all platforms.
 *
 * @retval LK_NO_DEVICE  No platform, or `index` is past the last device.
 */
LK_API enum lk_status lk_device_info(struct lk_device_info *out, size_t index);

#ifdef __cplusplus
}
#endif

#endif
