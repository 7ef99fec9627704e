// The trace kernel over the wide BVH without the instructions of one maker's CPUs.

#define WIDE_PORTABLE 1

#include "trace.cl"
