// The trace kernel with the queue of GPUs: groups of 32, whose first item fetches for all.

#define WARP_WIDTH 32

#include "trace.cl"
