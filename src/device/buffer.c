#include "device/buffer.h"

#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#define EMPTY_SIZE 16 // bytes of a buffer that holds nothing

#define PAGE_SIZE ((size_t)2 << 20) // of large pages, bytes

// Memory in large pages, as far as the system has them. Texels, nodes and triangles are met all
// over, and with pages of 4 KB a CPU looks most of them up: in large ones Sponza's bounces take the
// material stage a quarter less time, and trace a sixteenth.
static void *take_pages(size_t size)
{
    const size_t whole = (size + PAGE_SIZE - 1) / PAGE_SIZE * PAGE_SIZE;
    void *pages = aligned_alloc(PAGE_SIZE, whole);
#ifdef MADV_HUGEPAGE
    if (pages != NULL)
        madvise(pages, whole, MADV_HUGEPAGE); // where it fails, pages are small
#endif
    return pages;
}

enum status buffer_create(struct buffer *out, struct gpu *gpu, size_t size, const void *data,
                          const char *name)
{
    const size_t bytes = size > 0 ? size : EMPTY_SIZE;
    if (bytes > gpu->info.max_allocation)
        return status_fail(
            STATUS_NO_MEMORY, "%s: %.0f MB are more than device \"%s\" allocates at once (%.0f MB)",
            name, (double)bytes * 1e-6, gpu->info.name, (double)gpu->info.max_allocation * 1e-6);
    cl_int error = CL_SUCCESS;
    const bool copies = size > 0 && data != NULL;
    void *pages = gpu->info.is_cpu && bytes >= PAGE_SIZE ? take_pages(bytes) : NULL;
    if (pages != NULL && copies)
        memcpy(pages, data, size);
    void *host = pages != NULL ? pages : copies ? (void *)(uintptr_t)data : NULL;
    const cl_mem_flags use = pages != NULL ? CL_MEM_USE_HOST_PTR
                             : copies      ? CL_MEM_COPY_HOST_PTR
                                           : 0;
    cl_mem handle = clCreateBuffer(gpu->context, CL_MEM_READ_WRITE | use, bytes, host, &error);
    if (error != CL_SUCCESS) {
        free(pages);
        return gpu_fail(error, "clCreateBuffer", name);
    }
    *out = (struct buffer){.handle = handle, .size = bytes, .pages = pages};
    gpu->allocated += bytes;
    return STATUS_OK;
}

enum status buffer_write(struct gpu *gpu, const struct buffer *buffer, const void *data,
                         size_t size)
{
    const cl_int error =
        clEnqueueWriteBuffer(gpu->queue, buffer->handle, CL_TRUE, 0, size, data, 0, NULL, NULL);
    return error == CL_SUCCESS ? STATUS_OK
                               : gpu_fail(error, "clEnqueueWriteBuffer", gpu->info.name);
}

enum status buffer_read(struct gpu *gpu, const struct buffer *buffer, void *out, size_t size)
{
    const enum status status = gpu_wait(gpu);
    if (status != STATUS_OK)
        return status;
    const cl_int error =
        clEnqueueReadBuffer(gpu->queue, buffer->handle, CL_TRUE, 0, size, out, 0, NULL, NULL);
    return error == CL_SUCCESS ? STATUS_OK : gpu_fail(error, "clEnqueueReadBuffer", gpu->info.name);
}

enum status buffer_clear(struct gpu *gpu, const struct buffer *buffer)
{
    const cl_uint zero = 0;
    const cl_int error =
        clEnqueueFillBuffer(gpu->queue, buffer->handle, &zero, sizeof(zero), 0,
                            buffer->size / sizeof(zero) * sizeof(zero), 0, NULL, NULL);
    return error == CL_SUCCESS ? STATUS_OK : gpu_fail(error, "clEnqueueFillBuffer", gpu->info.name);
}

enum status buffer_view_rows(struct buffer *out, struct gpu *gpu, const struct buffer *rows,
                             const char *name)
{
    const size_t count = rows->size / (4 * sizeof(float));
    if (!gpu->info.has_images || count > gpu->info.image1d_max)
        return status_fail(STATUS_LIMIT,
                           "%s: %zu rows do not fit a 1D texture of device \"%s\" (%llu); use "
                           "--nodes buffer",
                           name, count, gpu->info.name, (unsigned long long)gpu->info.image1d_max);
    const cl_image_format format = {.image_channel_order = CL_RGBA,
                                    .image_channel_data_type = CL_FLOAT};
    cl_image_desc desc;
    memset(&desc, 0, sizeof(desc));
    desc.image_type = CL_MEM_OBJECT_IMAGE1D_BUFFER;
    desc.image_width = count;
    desc.buffer = rows->handle;
    cl_int error = CL_SUCCESS;
    cl_mem handle = clCreateImage(gpu->context, CL_MEM_READ_ONLY, &format, &desc, NULL, &error);
    if (error != CL_SUCCESS)
        return gpu_fail(error, "clCreateImage", name);
    *out = (struct buffer){.handle = handle, .size = 0};
    return STATUS_OK;
}

enum status buffer_create_image(struct buffer *out, struct gpu *gpu, uint32_t width,
                                uint32_t height, const uint32_t *texels, const char *name)
{
    if (!gpu->info.has_images)
        return status_fail(STATUS_LIMIT, "%s: device \"%s\" has no images; use --textures pool",
                           name, gpu->info.name);
    const cl_image_format format = {.image_channel_order = CL_RGBA,
                                    .image_channel_data_type = CL_UNSIGNED_INT8};
    cl_image_desc desc;
    memset(&desc, 0, sizeof(desc));
    desc.image_type = CL_MEM_OBJECT_IMAGE2D;
    desc.image_width = width;
    desc.image_height = height;
    cl_int error = CL_SUCCESS;
    cl_mem handle = clCreateImage(gpu->context, CL_MEM_READ_ONLY | CL_MEM_COPY_HOST_PTR, &format,
                                  &desc, (void *)(uintptr_t)texels, &error);
    if (error != CL_SUCCESS)
        return gpu_fail(error, "clCreateImage", name);
    const size_t bytes = (size_t)width * height * sizeof(*texels);
    *out = (struct buffer){.handle = handle, .size = bytes};
    gpu->allocated += bytes;
    return STATUS_OK;
}

void buffer_free(struct gpu *gpu, struct buffer *buffer)
{
    if (buffer->handle != NULL) {
        clReleaseMemObject(buffer->handle);
        gpu->allocated -= buffer->size;
    }
    if (buffer->pages != NULL) {
        gpu_wait(gpu); // for what was enqueued and uses them
        free(buffer->pages);
    }
    *buffer = (struct buffer){0};
}
