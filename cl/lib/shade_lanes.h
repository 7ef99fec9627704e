/**
 * @file
 * Shading of paths side by side, on CPUs: of most hits (lib/material_lanes.h, lib/bsdf_lanes.h).
 * Which way a hit goes is decided by that hit alone.
 */
#ifndef LIB_SHADE_LANES_H
#define LIB_SHADE_LANES_H

#include "lib/lanes.h"
#include "shared/path.h"

#ifndef SHADE_LANES
#if DEVICE_CPU
#define SHADE_LANES 1
#else
#define SHADE_LANES 0
#endif
#endif

#if SHADE_LANES

#define SHADE_RUN PATH_RUN

// Goes through the work item's slots, LANES at a time: i is the place of the first in the queue.
#define SHADE_LANES_LOOP(i, count)                                                                 \
    for (uint run_ = get_global_id(0) * SHADE_RUN; run_ < (count);                                 \
         run_ += get_global_size(0) * SHADE_RUN)                                                   \
        for (uint i = run_; i < min(run_ + SHADE_RUN, count); i += LANES)

// Reads the slots from place `first` of the queue on, one for each lane. Past its end the last one
// stands in. Returns bits of the lanes that are before it.
static inline uint shade_lanes_slots(uint *slots, __global const uint *queue, const uint first,
                                     const uint count)
{
    if (first + LANES <= count) {
        lanes_store(lanes_load(queue + first), slots);
        return LANES_ALL;
    }
    for (uint k = 0; k < LANES; k++)
        slots[k] = queue[min(first + k, count - 1)];
    return (1u << (count - first)) - 1u;
}

#endif

#endif
