/**
 * @file
 * Shading of paths side by side, on CPUs: of those hits that are Lambert, as most of most
 * scenes are. Which way a hit goes is decided by that hit alone.
 */
#ifndef LIB_SHADE_LANES_H
#define LIB_SHADE_LANES_H

#include "lib/lanes.h"
#include "shared/path.h"
#include "shared/ray.h"

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

// What bsdf_load() loads, as far as Lambert needs it, and the path's weight.
struct lambert_lanes {
    struct lanes3 org; // where rays leave the surface
    struct lanes3 normal, geometric;
    struct lanes3 diffuse;
    struct lanes3 throughput;
    lanes_int alone; // PATH_NO_BOUNCE
};

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

// Which slots hold a hit of nothing but the Lambert term, with those flags of `mask` that are
// `flags`.
static inline uint lambert_lanes_are(const uint *slots, const uint mask, const uint flags,
                                     __global const struct path *paths,
                                     __global const struct shade *shades)
{
    const uint all = mask | PATH_MIRROR | PATH_SHEEN | (0xffu << PATH_F90_SHIFT);
    const lanes_float bits = LANES_WORD(lanes_float, paths, slots, .throughput_bits.w);
    const lanes_uint specular = LANES_WORD(lanes_uint, shades, slots, .specular_f90.x) |
                                LANES_WORD(lanes_uint, shades, slots, .specular_f90.y);
    return lanes_bits((((lanes_as_uint(bits) & all) ^ flags) | specular) == 0u);
}

static inline struct lambert_lanes lambert_lanes_load(const uint *slots,
                                                      __global const struct ray *rays,
                                                      __global const struct path *paths,
                                                      __global const struct shade *shades)
{
    struct lambert_lanes out;
    const lanes_float normal = LANES_WORD(lanes_float, paths, slots, .radiance_normal.w);
    const struct lanes4 org = LANES_OF(rays, slots, .org);
    out.org = lanes3_xyz(org);
    out.normal = lanes_oct_unpack(lanes_as_uint(normal));
    out.geometric = lanes_oct_unpack(lanes_as_uint(org.w));
    out.diffuse =
        lanes3_xyz(lanes_unpack_shares(LANES_WORD(lanes_uint, shades, slots, .diffuse_f0.x),
                                       LANES_WORD(lanes_uint, shades, slots, .diffuse_f0.y)));
    const struct lanes4 throughput = LANES_OF(paths, slots, .throughput_bits);
    out.throughput = lanes3_xyz(throughput);
    out.alone = (lanes_as_uint(throughput.w) & PATH_NO_BOUNCE) != 0u;
    return out;
}

#endif

#endif
