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

// Hashes a text with its end, so that "ab", "c" differs from "a", "bc".
static uint64_t hash_text(uint64_t hash, const char *text)
{
    return hash_bytes(hash, text, strlen(text) + 1);
}

bool build_cache_key(struct build_key *out, const struct gpu *gpu, const char *text, size_t size,
                     const char *options)
{
    if (strcmp(gpu->info.platform, "Portable Computing Language") == 0)
        return false;
    // Two hashes from different starts make one of 128 bits.
    static const uint64_t starts[2] = {0xcbf29ce484222325u, 0x9ae16a3b2f90404fu};
    for (int i = 0; i < 2; i++) {
        uint64_t hash = starts[i];
        hash = hash_bytes(hash, text, size);
        hash = hash_text(hash, options);
        hash = hash_text(hash, gpu->info.platform);
        hash = hash_text(hash, gpu->info.platform_version);
        hash = hash_text(hash, gpu->info.name);
        hash = hash_text(hash, gpu->info.driver);
        hash = hash_text(hash, gpu->info.version);
        out->hash[i] = hash;
    }
    return true;
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
static bool cache_path(char *out, const struct build_key *key, bool make)
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
    snprintf(out, PATH_LENGTH, "%.4000s/%016llx%016llx.bin", folder,
             (unsigned long long)key->hash[0], (unsigned long long)key->hash[1]);
    return true;
}

struct _cl_program *build_cache_load(const struct build_key *key, const struct gpu *gpu,
                                     const char *options)
{
    char path[PATH_LENGTH];
    char *bytes = NULL;
    size_t size = 0;
    if (!cache_path(path, key, false) || file_read(&bytes, &size, path) != STATUS_OK)
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
    if (!cache_path(path, key, true) ||
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
