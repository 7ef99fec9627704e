#include "device/build_cache.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>

#include "core/file.h"
#include "core/log.h"
#include "device/cl_sources.h"

#define CACHE_MAGIC 0x314b4b4cu // "LKK1": the format of a file
#define PATH_LENGTH 4096

// The head of a cache file; the binary follows.
struct cache_head {
    uint32_t magic;
    uint32_t pad0;
    uint64_t hash[2];  // the key
    uint64_t size;     // bytes of the binary
    uint64_t checksum; // of the binary
};

// FNV-1a (Fowler, Noll, Vo), 64 bits.
static uint64_t hash_bytes(uint64_t hash, const void *bytes, size_t size)
{
    const unsigned char *p = bytes;
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ p[i]) * 0x100000001b3u;
    return hash;
}

// Starts of two hashes, which make one of 128 bits.
static const struct build_key no_key = {{0xcbf29ce484222325u, 0x9ae16a3b2f90404fu}};

static void add_bytes(struct build_key *key, const void *bytes, size_t size)
{
    for (int i = 0; i < 2; i++)
        key->hash[i] = hash_bytes(key->hash[i], bytes, size);
}

// Adds a text with its end, so that "ab", "c" differs from "a", "bc".
static void add_text(struct build_key *key, const char *text)
{
    add_bytes(key, text, strlen(text) + 1);
}

static void add_device(struct build_key *key, const struct gpu_info *info)
{
    add_text(key, info->platform);
    add_text(key, info->platform_version);
    add_text(key, info->name);
    add_text(key, info->driver);
    add_text(key, info->version);
}

bool build_cache_key(struct build_key *out, const struct gpu *gpu, const char *text, size_t size,
                     const char *options)
{
    if (strcmp(gpu->info.platform, "Portable Computing Language") == 0)
        return false;
    *out = no_key;
    add_bytes(out, text, size);
    add_text(out, options);
    add_device(out, &gpu->info);
    return true;
}

void build_cache_note_key(struct build_key *out, const struct gpu *gpu, const char *about)
{
    *out = no_key;
    for (size_t i = 0; i < cl_source_count; i++)
        add_bytes(out, cl_sources[i].text, cl_sources[i].size);
    add_text(out, about);
    add_device(out, &gpu->info);
}

// Makes a folder and those above it.
static bool make_folders(char *path)
{
    for (char *slash = strchr(path + 1, '/'); slash != NULL; slash = strchr(slash + 1, '/')) {
        *slash = '\0';
        const bool made = mkdir(path, 0777) == 0 || errno == EEXIST;
        *slash = '/';
        if (!made)
            return false;
    }
    return mkdir(path, 0777) == 0 || errno == EEXIST;
}

// The file of a key; false if there is no place for a cache.
static bool cache_path(char *out, const struct build_key *key, const char *suffix, bool make)
{
    char folder[PATH_LENGTH];
    const char *own = getenv("LIGHTKILN_CACHE_DIR");
    const char *xdg = getenv("XDG_CACHE_HOME");
    const char *home = getenv("HOME");
    int length;
    if (own != NULL && own[0] != '\0')
        length = snprintf(folder, sizeof(folder), "%s", own);
    else if (xdg != NULL && xdg[0] == '/')
        length = snprintf(folder, sizeof(folder), "%s/lightkiln", xdg);
    else if (home != NULL && home[0] == '/')
        length = snprintf(folder, sizeof(folder), "%s/.cache/lightkiln", home);
    else
        return false;
    if (length >= (int)sizeof(folder) - 64 || (make && !make_folders(folder)))
        return false;
    snprintf(out, PATH_LENGTH, "%.4000s/%016llx%016llx.%s", folder,
             (unsigned long long)key->hash[0], (unsigned long long)key->hash[1], suffix);
    return true;
}

struct _cl_program *build_cache_load(const struct build_key *key, const struct gpu *gpu,
                                     const char *options)
{
    char path[PATH_LENGTH];
    char *bytes = NULL;
    size_t size = 0;
    if (!cache_path(path, key, "bin", false) || file_read(&bytes, &size, path) != STATUS_OK)
        return NULL;

    // Believe nothing in the file that does not fit.
    cl_program program = NULL;
    struct cache_head head;
    if (size < sizeof(head))
        goto cleanup;
    memcpy(&head, bytes, sizeof(head));
    const unsigned char *binary = (const unsigned char *)bytes + sizeof(head);
    const size_t binary_size = size - sizeof(head);
    if (head.magic != CACHE_MAGIC || memcmp(head.hash, key->hash, sizeof(head.hash)) != 0 ||
        head.size != binary_size || head.checksum != hash_bytes(0, binary, binary_size))
        goto cleanup;

    cl_int error = CL_SUCCESS;
    cl_int binary_error = CL_SUCCESS;
    program = clCreateProgramWithBinary(gpu->context, 1, &gpu->device, &binary_size, &binary,
                                        &binary_error, &error);
    if (error != CL_SUCCESS || binary_error != CL_SUCCESS ||
        clBuildProgram(program, 1, &gpu->device, options, NULL, NULL) != CL_SUCCESS) {
        if (program != NULL)
            clReleaseProgram(program);
        program = NULL;
    }

cleanup:
    if (program == NULL)
        log_message(LOG_DEBUG, "build cache: %s does not fit, building from source", path);
    free(bytes);
    return program;
}

void build_cache_save(const struct build_key *key, struct _cl_program *program)
{
    char path[PATH_LENGTH];
    size_t size = 0;
    if (!cache_path(path, key, "bin", true) ||
        clGetProgramInfo(program, CL_PROGRAM_BINARY_SIZES, sizeof(size), &size, NULL) !=
            CL_SUCCESS ||
        size == 0)
        return;
    struct cache_head head = {.magic = CACHE_MAGIC, .size = size};
    unsigned char *bytes = malloc(sizeof(head) + size);
    if (bytes == NULL)
        return;
    unsigned char *binary = bytes + sizeof(head);
    if (clGetProgramInfo(program, CL_PROGRAM_BINARIES, sizeof(binary), &binary, NULL) ==
        CL_SUCCESS) {
        memcpy(head.hash, key->hash, sizeof(head.hash));
        head.checksum = hash_bytes(0, binary, size);
        memcpy(bytes, &head, sizeof(head));
        if (file_write(path, bytes, sizeof(head) + size) != STATUS_OK)
            log_message(LOG_DEBUG, "build cache: %s", status_message());
    }
    free(bytes);
}

char *build_cache_note_load(const struct build_key *key)
{
    char path[PATH_LENGTH];
    char *text = NULL;
    size_t size = 0;
    if (!cache_path(path, key, "txt", false) || file_read(&text, &size, path) != STATUS_OK)
        return NULL;
    return text;
}

void build_cache_note_save(const struct build_key *key, const char *text)
{
    char path[PATH_LENGTH];
    if (cache_path(path, key, "txt", true) && file_write(path, text, strlen(text)) != STATUS_OK)
        log_message(LOG_DEBUG, "build cache: %s", status_message());
}
