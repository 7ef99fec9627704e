/**
 * @file
 * Kernels: built from the embedded sources (or the build cache), given arguments, launched.
 *
 * The cache holds one file a program in LIGHTKILN_CACHE_DIR, else XDG_CACHE_HOME/lightkiln, else
 * ~/.cache/lightkiln. Its key is a hash of the expanded source, the options, platform, device,
 * driver and version, and a format number. Any trouble with it means a build from source, never an
 * error. PoCL keeps a cache of its own that goes further (machine code for one group size), so ours
 * is not used there.
 */
#ifndef DEVICE_PROGRAM_H
#define DEVICE_PROGRAM_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "core/status.h"
#include "device/buffer.h"
#include "device/gpu.h"

/** Layouts of the BVH; 0 stands for none. */
enum bvh_layout { LAYOUT_BINARY = 1, LAYOUT_WIDE, LAYOUT_QUAD, LAYOUT_COMPRESSED, LAYOUT_END };

/** Which variant of the kernels to build. */
struct program_options {
    bool persistent;     // trace, direct, directional: work from a queue
    bool bvh_wide;       // the 8-wide BVH instead of the binary one
    bool bvh_quad;       // the 4-wide one instead
    bool bvh_compressed; // the compressed one instead
    bool warp_votes;     // trace, direct, directional: lanes of a warp vote (lib/warp.h)
    bool nodes_image;    // binary BVH's nodes through a 1D texture
    bool ray_spans;      // trace: rays carry how near and how far they look
    bool any_hit;        // trace: some hit instead of the nearest
    bool alpha;          // the scene has materials that let rays by
    bool textures_bound; // material: one launch a material, its textures as images
    bool normal_maps;    // the scene has materials with normal maps
    bool layers;         // the scene has materials with some of lib/layers.h
    bool sheen;          // the scene has materials with a sheen; layers, too
    int light_sampler;   // direct, material: LIGHT_SAMPLER_... of shared/settings.h
    bool brdf_phong;     // the thesis's BSDF
    bool environment;    // directional: there is an environment
    bool no_emitters;    // material: no triangle is an emitter
    bool few_lights;     // direct, material: the root of the light BVH has them all
    uint32_t registers;  // bounce: an item takes so many at most; 0: as many as the compiler likes
    uint32_t untextured; // bits of enum texture_use: no material has such a texture
    bool no_cache;       // build from source
    const char *more;    // options for the compiler beside all these; NULL: none. Borrowed
};

/** The layout that kernels built so read. */
enum bvh_layout program_layout(const struct program_options *options);

/** A built program. All zero is a valid empty one. */
struct program {
    struct _cl_program *handle; // owned
    bool from_source;           // not from the cache
};

struct kernel {
    struct _cl_kernel *handle; // owned
    char name[32];
    size_t group_size; // work items in a group, as the kernel says, else as the device likes
    bool persistent;   // its items take work from a queue (lib/queue.h)
};

/** One argument of a kernel: ARG_BUFFER or ARG_VALUE. */
struct kernel_arg {
    size_t size;
    const void *value; // borrowed until the kernel is enqueued
};

#define ARG_BUFFER(buffer)                                                                         \
    {                                                                                              \
        sizeof((buffer)->handle), &(buffer)->handle                                                \
    }
#define ARG_VALUE(variable)                                                                        \
    {                                                                                              \
        sizeof(variable), &(variable)                                                              \
    }

/**
 * Builds cl/NAME.cl for a device.
 *
 * @retval STATUS_DEVICE  It does not compile; the message holds the options and the build log.
 */
enum status program_build(struct program *out, const struct gpu *gpu, const char *name,
                          const struct program_options *options);

/** Builds a program from a text of the caller's: for tests of single functions. */
enum status program_build_text(struct program *out, const struct gpu *gpu, const char *text,
                               size_t size, const struct program_options *options);

/**
 * Whether kernels may be built with warp_votes and registers: on NVIDIA's platform, where a trial
 * compile works. Others are not tried, since a compiler may not survive another machine's
 * instructions.
 */
bool program_takes_votes(const struct gpu *gpu);

void program_free(struct program *program);

/**
 * Takes a kernel out of a program. It keeps the program alive.
 *
 * @retval STATUS_DEVICE  There is no such kernel, or its group is larger than the device allows.
 */
enum status kernel_create(struct kernel *out, const struct gpu *gpu, const struct program *program,
                          const char *name);

/** Builds cl/NAME.cl and takes out the one kernel of the same name; adds to *built if it was
 * compiled. */
enum status kernel_build(struct kernel *out, const struct gpu *gpu, const char *name,
                         const struct program_options *options, uint32_t *built);

/**
 * Enqueues a kernel and returns.
 *
 * @param args   [arg_count], all of the kernel's arguments in order.
 * @param items  Work items; rounded up to whole groups. 0 enqueues nothing.
 */
enum status kernel_enqueue(struct gpu *gpu, const struct kernel *kernel,
                           const struct kernel_arg *args, size_t arg_count, size_t items);

void kernel_free(struct kernel *kernel);

#endif
