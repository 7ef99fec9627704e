/**
 * @file
 * Prefetching on CPUs, where one work item follows the other and nothing hides a miss.
 */
#ifndef LIB_PREFETCH_H
#define LIB_PREFETCH_H

#include "shared/base.h"

#if DEVICE_CPU && defined(__has_builtin)
#if __has_builtin(__builtin_prefetch)
#define PREFETCHES 1
#endif
#endif

// Asks for a cache line of global memory. The built-in takes no global pointers, but on a CPU all
// address spaces are one. Elsewhere nothing is done.
#if PREFETCHES
#define PREFETCH(pointer) __builtin_prefetch((const void *)(ulong)(pointer))
#else
#define PREFETCH(pointer) (void)(pointer)
#endif

#endif
