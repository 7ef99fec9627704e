/**
 * @file
 * The build cache (device/program.h tells where and when); used within this folder.
 */
#ifndef DEVICE_BUILD_CACHE_H
#define DEVICE_BUILD_CACHE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "device/gpu.h"

/** What names one build. */
struct build_key {
    uint64_t hash[2];
};

/** Makes the key of a build. @return false if builds for this device are not to be cached. */
bool build_cache_key(struct build_key *out, const struct gpu *gpu, const char *text, size_t size,
                     const char *options);

/** Loads and builds a cached binary; NULL if there is none that works. */
struct _cl_program *build_cache_load(const struct build_key *key, const struct gpu *gpu,
                                     const char *options);

/** Keeps a program's binary, if that can be done. */
void build_cache_save(const struct build_key *key, struct _cl_program *program);

#endif
