/**
 * @file
 * The build cache (device/program.h tells where and when), and notes beside the binaries: small
 * texts on what was found out about a device.
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

/** Makes the key of a note: of the device, of the text of all kernels, and of what it is about. */
void build_cache_note_key(struct build_key *out, const struct gpu *gpu, const char *about);

/** Reads a note, for free(); NULL if there is none. It may hold anything. */
char *build_cache_note_load(const struct build_key *key);

/** Keeps a note, if that can be done. */
void build_cache_note_save(const struct build_key *key, const char *text);

#endif
