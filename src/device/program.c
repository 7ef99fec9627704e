#include "device/program.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "core/clock.h"
#include "core/log.h"
#include "device/build_cache.h"
#include "device/cl_sources.h"
#include "device/profile.h"

#define OPTIONS_MAX 1024 // bytes of a build's options

// Appends "-D NAME=value" if the text knows the name, so that a program is not built anew for a
// choice that cannot change it.
static void add_define(char *options, const char *text, const char *name, int value)
{
    if (strstr(text, name) == NULL)
        return;
    const size_t used = strlen(options);
    snprintf(options + used, OPTIONS_MAX - used, " -D %s=%d", name, value);
}

// Turns run-time choices into build options.
static void write_options(char *options, const char *text, const struct gpu *gpu,
                          const struct program_options *chosen)
{
    // Denormals and the sign of zero mean nothing to light, and cost instructions to keep.
    snprintf(options, OPTIONS_MAX,
             "-cl-std=CL1.2 -cl-mad-enable -cl-denorms-are-zero -cl-no-signed-zeros -D DEVICE=1");
    // An H100 renders 3 to 10 % faster, and Sponza's variance between the two is 5e-10 where its
    // noise at 1024 samples is 7e-6. CPUs are left exact: what is slow there is written by hand.
    if (!gpu->info.is_cpu)
        strcat(options, " -cl-fast-relaxed-math");
    add_define(options, text, "DEVICE_CPU", gpu->info.is_cpu);
    add_define(options, text, "PERSISTENT", chosen->persistent);
    add_define(options, text, "BVH_WIDE", chosen->bvh_wide);
    add_define(options, text, "BVH_QUAD", chosen->bvh_quad);
    add_define(options, text, "BVH_COMPRESSED", chosen->bvh_compressed);
    if (chosen->warp_votes)
        add_define(options, text, "WARP_VOTES", 1);
    add_define(options, text, "NODES_IMAGE", chosen->nodes_image);
    add_define(options, text, "RAY_SPANS", chosen->ray_spans);
    add_define(options, text, "ANY_HIT", chosen->any_hit);
    add_define(options, text, "ALPHA", chosen->alpha);
    add_define(options, text, "TEXTURES_BOUND", chosen->textures_bound);
    add_define(options, text, "NORMAL_MAPS", chosen->normal_maps);
    add_define(options, text, "LAYERS", chosen->layers);
    add_define(options, text, "SHEEN_LOBE", chosen->sheen);
    add_define(options, text, "BRDF_PHONG", chosen->brdf_phong);
    add_define(options, text, "ENV_MAP", chosen->environment);
    add_define(options, text, "EMITTERS", !chosen->no_emitters);
    add_define(options, text, "LIGHT_BVH_FLAT", chosen->few_lights);
    add_define(options, text, "UNTEXTURED", (int)chosen->untextured);
    if (chosen->light_sampler != 0)
        add_define(options, text, "LIGHT_SAMPLER", chosen->light_sampler);
    size_t used = strlen(options);
    if (chosen->registers != 0 && strstr(text, "REGISTERS_MOST") != NULL)
        used += (size_t)snprintf(options + used, OPTIONS_MAX - used,
                                 " -D REGISTERS_MOST=%u -cl-nv-maxrregcount=%u", chosen->registers,
                                 chosen->registers);
    if (chosen->more != NULL)
        snprintf(options + used, OPTIONS_MAX - used, " %s", chosen->more);
}

enum bvh_layout program_layout(const struct program_options *options)
{
    return options->bvh_wide         ? LAYOUT_WIDE
           : options->bvh_quad       ? LAYOUT_QUAD
           : options->bvh_compressed ? LAYOUT_COMPRESSED
                                     : LAYOUT_BINARY;
}

// The build log, to be released with free(); NULL if there is none.
static char *build_log(cl_program program, cl_device_id device)
{
    size_t size = 0;
    if (clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, 0, NULL, &size) !=
            CL_SUCCESS ||
        size < 2)
        return NULL;
    char *log = calloc(1, size + 1);
    if (log != NULL)
        clGetProgramBuildInfo(program, device, CL_PROGRAM_BUILD_LOG, size, log, NULL);
    return log;
}

// Compiles a text for one device. On success the caller owns the program.
static enum status build_from_source(cl_program *out, const struct gpu *gpu, const char *text,
                                     size_t size, const char *options)
{
    enum status status = STATUS_OK;
    char *log = NULL;
    cl_int error = CL_SUCCESS;

    cl_program program = clCreateProgramWithSource(gpu->context, 1, &text, &size, &error);
    if (error != CL_SUCCESS)
        return gpu_fail(error, "clCreateProgramWithSource", gpu->info.name);

    error = clBuildProgram(program, 1, &gpu->device, options, NULL, NULL);
    if (error != CL_SUCCESS) {
        log = build_log(program, gpu->device); // NULL if there is none
        status = status_fail(STATUS_DEVICE, "clBuildProgram: %s, device \"%s\", options \"%s\"\n%s",
                             gpu_error_name(error), gpu->info.name, options,
                             log != NULL ? log : "(no log)");
        goto cleanup;
    }
    *out = program;
    program = NULL; // the caller owns it now

cleanup:
    free(log);
    if (program != NULL)
        clReleaseProgram(program);
    return status;
}

// Builds a text, which messages know by a name.
static enum status build_named(struct program *out, const struct gpu *gpu, const char *name,
                               const char *text, size_t size, const struct program_options *chosen)
{
    char options[OPTIONS_MAX];
    write_options(options, text, gpu, chosen);

    struct build_key key;
    const bool cached = !chosen->no_cache && build_cache_key(&key, gpu, text, size, options);
    cl_program handle = cached ? build_cache_load(&key, gpu, options) : NULL;
    const bool from_source = handle == NULL;
    const double start_s = clock_seconds();
    if (from_source) {
        const enum status status = build_from_source(&handle, gpu, text, size, options);
        if (status != STATUS_OK)
            return status;
        if (cached)
            build_cache_save(&key, handle);
    }
    if (from_source)
        log_message(LOG_DEBUG, "compiled %s in %.3f s: %s", name, clock_seconds() - start_s,
                    options);
    *out = (struct program){.handle = handle, .from_source = from_source};
    return STATUS_OK;
}

enum status program_build_text(struct program *out, const struct gpu *gpu, const char *text,
                               size_t size, const struct program_options *options)
{
    return build_named(out, gpu, "a text", text, size, options);
}

enum status program_build(struct program *out, const struct gpu *gpu, const char *name,
                          const struct program_options *options)
{
    for (size_t i = 0; i < cl_source_count; i++)
        if (strcmp(cl_sources[i].name, name) == 0)
            return build_named(out, gpu, name, cl_sources[i].text, cl_sources[i].size, options);
    return status_fail(STATUS_DEVICE, "no kernel source named \"%s\" is built in", name);
}

bool program_takes_votes(const struct gpu *gpu)
{
    const struct program_options options = {.registers = 64};
    struct program program = {0};
    if (strstr(gpu->info.platform, "NVIDIA") == NULL ||
        program_build(&program, gpu, "probe_votes", &options) != STATUS_OK)
        return false;
    program_free(&program);
    return true;
}

void program_free(struct program *program)
{
    if (program->handle != NULL)
        clReleaseProgram(program->handle);
    *program = (struct program){0};
}

// Takes a kernel out of a program.
//
//   open_groups  it may leave the size of its groups open; they are as the device likes them then
static enum status take_kernel(struct kernel *out, const struct gpu *gpu,
                               const struct program *program, const char *name,
                               const bool open_groups)
{
    cl_int error = CL_SUCCESS;
    cl_kernel handle = clCreateKernel(program->handle, name, &error);
    if (error != CL_SUCCESS)
        return gpu_fail(error, "clCreateKernel", name);

    // The kernel decides the size of its groups.
    size_t sizes[3] = {0};
    error = clGetKernelWorkGroupInfo(handle, gpu->device, CL_KERNEL_COMPILE_WORK_GROUP_SIZE,
                                     sizeof(sizes), sizes, NULL);
    if (error == CL_SUCCESS && sizes[0] == 0 && open_groups)
        error = clGetKernelWorkGroupInfo(handle, gpu->device,
                                         CL_KERNEL_PREFERRED_WORK_GROUP_SIZE_MULTIPLE,
                                         sizeof(sizes[0]), sizes, NULL);
    if (error != CL_SUCCESS || sizes[0] == 0) {
        clReleaseKernel(handle);
        if (error != CL_SUCCESS)
            return gpu_fail(error, "clGetKernelWorkGroupInfo", name);
        return status_fail(STATUS_DEVICE, "kernel %s does not say its group size", name);
    }
    *out = (struct kernel){.handle = handle, .group_size = sizes[0]};
    snprintf(out->name, sizeof(out->name), "%s", name);
    return STATUS_OK;
}

enum status kernel_create(struct kernel *out, const struct gpu *gpu, const struct program *program,
                          const char *name)
{
    return take_kernel(out, gpu, program, name, false);
}

enum status kernel_build(struct kernel *out, const struct gpu *gpu, const char *name,
                         const struct program_options *options, uint32_t *built)
{
    struct program program = {0};
    enum status status = program_build(&program, gpu, name, options);
    if (status != STATUS_OK)
        return status;
    *built += program.from_source;
    status = take_kernel(out, gpu, &program, name, options->registers != 0);
    if (status == STATUS_OK)
        out->persistent = options->persistent;
    program_free(&program);
    return status;
}

enum status kernel_enqueue(struct gpu *gpu, const struct kernel *kernel,
                           const struct kernel_arg *args, size_t arg_count, size_t items)
{
    if (items == 0)
        return STATUS_OK;
    for (size_t i = 0; i < arg_count; i++) {
        const cl_int error =
            clSetKernelArg(kernel->handle, (cl_uint)i, args[i].size, args[i].value);
        if (error != CL_SUCCESS) {
            char what[64];
            snprintf(what, sizeof(what), "%s, argument %zu", kernel->name, i);
            return gpu_fail(error, "clSetKernelArg", what);
        }
    }

    const size_t local = kernel->group_size;
    const size_t global = (items + local - 1) / local * local;
    cl_event event = NULL;
    const cl_int error =
        clEnqueueNDRangeKernel(gpu->queue, kernel->handle, 1, NULL, &global, &local, 0, NULL,
                               gpu->profile != NULL ? &event : NULL);
    if (error != CL_SUCCESS)
        return gpu_fail(error, "clEnqueueNDRangeKernel", kernel->name);
    if (event != NULL)
        profile_add(gpu->profile, kernel->name, event);
    return STATUS_OK;
}

void kernel_free(struct kernel *kernel)
{
    if (kernel->handle != NULL)
        clReleaseKernel(kernel->handle);
    *kernel = (struct kernel){0};
}
