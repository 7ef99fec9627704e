/**
 * @file
 * Memory on the device: buffers and images. All zero is a valid empty one of each.
 */
#ifndef DEVICE_BUFFER_H
#define DEVICE_BUFFER_H

#include <stddef.h>
#include <stdint.h>

#include "core/status.h"
#include "device/gpu.h"

struct buffer {
    struct _cl_mem *handle; // owned
    size_t size;            // bytes
    void *pages;            // where a CPU keeps it, if that is ours; owned
};

/**
 * Creates a buffer.
 *
 * @param size  Bytes; 0 makes one of 16, since OpenCL has no empty buffers and kernels want an
 * argument.
 * @param data  [size] to start with, or NULL: not set.
 * @param name  For messages.
 * @retval STATUS_NO_MEMORY  Larger than the device's largest allocation, or it does not fit.
 */
enum status buffer_create(struct buffer *out, struct gpu *gpu, size_t size, const void *data,
                          const char *name);

/** Copies [size] bytes to the start of the buffer, waiting. */
enum status buffer_write(struct gpu *gpu, const struct buffer *buffer, const void *data,
                         size_t size);

/** Copies [size] bytes from the start of the buffer, after everything enqueued before; waits. */
enum status buffer_read(struct gpu *gpu, const struct buffer *buffer, void *out, size_t size);

/** Sets every byte to zero. */
enum status buffer_clear(struct gpu *gpu, const struct buffer *buffer);

/**
 * Views a buffer of float4 rows as a 1D texture.
 *
 * @retval STATUS_LIMIT  More rows than the device's textures hold.
 */
enum status buffer_view_rows(struct buffer *out, struct gpu *gpu, const struct buffer *rows,
                             const char *name);

/** Creates a 2D image of 8-bit RGBA read as unsigned integers. */
enum status buffer_create_image(struct buffer *out, struct gpu *gpu, uint32_t width,
                                uint32_t height, const uint32_t *texels, const char *name);

void buffer_free(struct gpu *gpu, struct buffer *buffer);

#endif
