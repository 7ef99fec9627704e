/**
 * @file
 * The ground of every shared header: OpenCL's names for the host, and the size check.
 *
 * Headers in this folder are compiled twice, as host C11 and as OpenCL C 1.2. Kernel builds say so
 * with
 * `-D DEVICE`. What may stand here: 32-bit scalars, rows of four, enums, and `static inline`
 * functions of them that use no pointer, no address space, no vector literal and no vector
 * operator, since the two dialects differ in those. Structs hold 32-bit scalars and rows of four
 * only: float3 takes 16 bytes on one side and 12 on the other, and pointers, bool, long and
 * bit-fields have no fixed size.
 */
#ifndef SHARED_BASE_H
#define SHARED_BASE_H

#ifdef DEVICE

// A struct that does not have the size both sides agreed on stops the build.
#define SHARED_SIZE(name, bytes)                                                                   \
    typedef char name##_is_##bytes##_bytes[sizeof(struct name) == (bytes) ? 1 : -1]

// A struct of four scalars that kernels read and write whole, as a row.
#define SHARED_ROW __attribute__((aligned(16)))

#else

#define SHARED_ROW

#if defined(__OPENCL_VERSION__) || defined(__OPENCL_C_VERSION__)
#error "kernel builds pass -D DEVICE"
#endif

#include <stdint.h>

typedef unsigned int uint;

typedef struct uint2 {
    uint x, y;
} uint2;

typedef struct uint4 {
    uint x, y, z, w;
} uint4;

typedef struct float2 {
    float x, y;
} float2;

typedef struct float4 {
    float x, y, z, w;
} float4;

#define SHARED_SIZE(name, bytes)                                                                   \
    _Static_assert(sizeof(struct name) == (bytes), "struct " #name " must be " #bytes " bytes")

#endif

#endif
