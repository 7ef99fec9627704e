/**
 * @file
 * Prefix sums: of one work-group, and of an array by one work-group. Sorting is made of these.
 *
 * Both work on tiles: a group takes SCAN_TILE consecutive elements, each item SCAN_RUN of them in
 * order, so that order is kept by construction.
 */
#ifndef LIB_SCAN_H
#define LIB_SCAN_H

#include "shared/base.h"

// On CPUs a barrier costs a nanosecond an item, so few items take long runs.
#ifndef WG_SCAN
#if DEVICE_CPU
#define WG_SCAN 16
#else
#define WG_SCAN 256
#endif
#endif

#ifndef SCAN_RUN
#if DEVICE_CPU
#define SCAN_RUN 64u
#else
#define SCAN_RUN 4u
#endif
#endif

#define SCAN_TILE ((uint)WG_SCAN * SCAN_RUN)

// Replaces values[0 .. WG_SCAN) by the sums of those before each, and returns the sum of all. Every
// item of the group calls it; values are settled on return.
//
// Source: W. Hillis, G. Steele, "Data Parallel Algorithms", CACM 29(12), 1986.
static inline uint scan_group(__local uint *values)
{
    const uint item = get_local_id(0);
    barrier(CLK_LOCAL_MEM_FENCE);
    // Written out, as NVIDIA's compiler does, the steps are a third of what scans a queue.
#pragma unroll 1
    for (uint step = 1; step < WG_SCAN; step *= 2) {
        const uint left = item >= step ? values[item - step] : 0u;
        barrier(CLK_LOCAL_MEM_FENCE);
        values[item] += left;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
    const uint before = item > 0 ? values[item - 1] : 0u;
    const uint total = values[WG_SCAN - 1];
    barrier(CLK_LOCAL_MEM_FENCE);
    values[item] = before;
    barrier(CLK_LOCAL_MEM_FENCE);
    return total;
}

// Replaces array[0 .. count) by the sums of the elements before each, and returns the sum of all.
// Called by every item of the one group there is.
static inline uint scan_array(__global uint *array, const uint count, __local uint *values)
{
    const uint item = get_local_id(0);
    const uint run = (count + WG_SCAN - 1) / WG_SCAN;
    const uint first = min(item * run, count);
    const uint end = min(first + run, count);

    // Sum the item's run, find what comes before it, then write the sums out.
    uint sum = 0;
    for (uint i = first; i < end; i++)
        sum += array[i];
    values[item] = sum;
    const uint total = scan_group(values);
    uint before = values[item];
    for (uint i = first; i < end; i++) {
        const uint element = array[i];
        array[i] = before;
        before += element;
    }
    return total;
}

#endif
