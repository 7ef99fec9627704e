/**
 * @file
 * How a work item comes by its work: plainly, one item each, or persistently, from a queue.
 *
 * Source of the queue: T. Aila, S. Laine, HPG 2009: a warp fetches its next rays by one atomic add.
 * Emulated in plain OpenCL C 1.2: the group is the warp, its first item fetches for all and hands
 * the place on through local memory. WARP_WIDTH is 32 on GPUs; on CPUs it is 1 and needs no
 * barrier. With WARP_VOTES the warp is the hardware's own, and no barrier is needed either.
 *
 * A kernel writes, with `queue` in scope as QUEUE_LOCAL:
 *
 *     QUEUE_LOCAL(queue);
 *     for (uint i = queue_first(head, queue); i - get_local_id(0) < count; i = queue_next(...))
 *         if (i < count)
 *             work(i);
 *
 * The loop's condition is the same for the whole group, so no item leaves before a barrier.
 */
#ifndef LIB_QUEUE_H
#define LIB_QUEUE_H

#include "lib/warp.h"
#include "shared/base.h"

#ifndef WARP_WIDTH
#if DEVICE_CPU
#define WARP_WIDTH 1
#else
#define WARP_WIDTH 32
#endif
#endif

// Size of a group of a kernel that traces. Two warps: a finished group frees its place at once, but
// an NVIDIA unit holds 32 groups at most, half its warps if there is one in each (an H100 traces 2
// to 6 % more rays/s than with 32; but see cl/trace.cl). On CPUs PoCL's runs of 64 items hide its
// scheduling.
#ifndef WG_TRACE
#if PERSISTENT && WARP_VOTES && BVH_QUAD
#define WG_TRACE 1024 // an H100 traces primary rays at 3 to 9 % more rays/s than with 128
#elif PERSISTENT && WARP_VOTES
#define WG_TRACE 128 // four warps, each with a queue of its own; but see lib/light_group.h
#elif PERSISTENT
#define WG_TRACE WARP_WIDTH
#else
#define WG_TRACE 64
#endif
#endif

#if PERSISTENT

#if WARP_VOTES

#define QUEUE_LOCAL(name) const uint name = (uint)get_local_id(0) % WARP_LANES

// Fetches the warp's next run of WARP_LANES places; returns this lane's.
static inline uint queue_fetch(volatile __global uint *head, const uint lane)
{
    uint first = 0;
    if (lane == 0)
        first = atomic_add(head, WARP_LANES);
    return warp_first(first) + lane;
}

#elif WARP_WIDTH > 1

#define QUEUE_LOCAL(name) __local uint name[1]

// Fetches the group's next run of WARP_WIDTH places; returns this item's.
static inline uint queue_fetch(volatile __global uint *head, __local uint *queue)
{
    barrier(CLK_LOCAL_MEM_FENCE);
    if (get_local_id(0) == 0)
        queue[0] = atomic_add(head, WARP_WIDTH);
    barrier(CLK_LOCAL_MEM_FENCE);
    return queue[0] + get_local_id(0);
}

#else

#define QUEUE_LOCAL(name)                                                                          \
    uint name[2];                                                                                  \
    name[1] = 0

// Places fetched at once: enough that threads do not read neighbouring rays in turns, which defeats
// the caches' own prefetching. With 16, two threads trace shadow rays in Sponza 5 to 20 % slower.
#define QUEUE_RUN 256u

// Hands out the places of the item's run, and fetches the next run at its end.
static inline uint queue_fetch(volatile __global uint *head, uint *queue)
{
    if (queue[1] == 0) {
        queue[0] = atomic_add(head, QUEUE_RUN);
        queue[1] = QUEUE_RUN;
    }
    queue[1]--;
    return queue[0]++;
}

#endif

#define queue_first(head, queue)   queue_fetch(head, queue)
#define queue_next(i, head, queue) queue_fetch(head, queue)
#if WARP_VOTES
#define queue_group(i) ((i) - (uint)get_local_id(0) % WARP_LANES)
#else
#define queue_group(i) ((i) - (uint)get_local_id(0))
#endif

#else

#define QUEUE_LOCAL(name)          const uint name = 0
#define queue_first(head, queue)   ((uint)get_global_id(0) + (queue))
#define queue_next(i, head, queue) 0xffffffffu
#define queue_group(i)             (i)

#endif

#endif
