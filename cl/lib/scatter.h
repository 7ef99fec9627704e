/**
 * @file
 * The direction in which a path goes on from its shaded hit, and its place in the next bounce's
 * queue: of one path, and on CPUs of eight side by side. For the stage that adds the last light,
 * where the hit is at hand, and for cl/scatter.cl where there is none. An H100 renders the Cornell
 * box 23 % faster than with a launch of its own and three that compact the queue, Sponza 6 %,
 * Sibenik 8 %.
 *
 * What is computed does not depend on the order of a queue, so paths line up as they are done:
 * neighbours stay together, runs of them come in any order.
 */
#ifndef LIB_SCATTER_H
#define LIB_SCATTER_H

#include "lib/bsdf.h"
#include "lib/bsdf_lanes.h"
#include "lib/samples.h"

// The bits of a path that goes on.
static inline uint scatter_flags(__constant struct settings *settings, const uint bounce)
{
    return PATH_ALIVE | (bounce + 1 == settings->depth ? PATH_COLLECT : 0u);
}

// Sends the path of one slot on. Returns whether it goes on.
static inline bool scatter_slot(__constant struct settings *settings, const struct batch batch,
                                const uint bounce, const uint slot,
                                __global const struct shade *restrict shades,
                                __global struct ray *restrict rays,
                                __global struct path *restrict paths,
                                __global const uint4 *restrict points,
                                __global const uint *restrict places)
{
    const float4 throughput_bits = paths[slot].throughput_bits;
    const uint bits = as_uint(throughput_bits.w);
    if ((bits & (PATH_SHADED | PATH_NO_BOUNCE)) == PATH_SHADED) {
        const struct bsdf b = bsdf_load(&rays[slot], &paths[slot], &shades[slot]);
        const struct path_place place = samples_place(batch, places, slot);
        const uint4 numbers =
            samples_draw(settings, points, place.pixel, place.sample, bounce, RNG_USE_BSDF, 0);
        const struct bsdf_sample sampled = bsdf_sample(
            &b, (float3)(rng_unit(numbers.x), rng_unit(numbers.y), rng_unit(numbers.z)));
        const float3 throughput = throughput_bits.xyz * sampled.weight;

        // Russian roulette by what is left of the path's weight (thesis section 3.5).
        float survival = 1.0f;
        if (bounce >= settings->roulette_depth) {
            survival = max3(throughput);
            if (settings->quantity == QUANTITY_IRRADIANCE)
                survival *= INV_PI;
            survival = min2(survival, 1.0f);
        }
        if (max3(throughput) > 0.0f && rng_unit(numbers.w) < survival) {
            const uint next_bits =
                scatter_flags(settings, bounce) | (sampled.specular ? PATH_SPECULAR : 0u);
            paths[slot].throughput_bits = (float4)(throughput / survival, as_float(next_bits));
            rays[slot].dir = (float4)(sampled.dir, sampled.density);
            return true;
        }
    }
    paths[slot].throughput_bits.w = as_float(0u);
    return false;
}

// What a kernel takes that adds the last light of a hit, and sends the path on, too.
#define SCATTER_PARAMETERS                                                                         \
    const uint scatters, __global uint *restrict queue_out // whether it does, and the next queue

#if SHADE_LANES

// How paths go on, side by side.
struct scatter_lanes {
    struct lanes3 dir, throughput;
    lanes_float density; // of the direction, 1/sr
    lanes_int goes;      // whether they do
};

static inline struct lanes_numbers scatter_lanes_numbers(__constant struct settings *settings,
                                                         const struct lanes_place place,
                                                         __global const uint4 *restrict points)
{
    return lanes_draw(settings, points, place, place.sample, RNG_USE_BSDF, (lanes_uint)(0u));
}

// As scatter_slot(), for paths whose BSDFs are in b.
static inline struct scatter_lanes scatter_lanes_sample(__constant struct settings *settings,
                                                        const struct lanes_place place,
                                                        const struct lanes_numbers numbers,
                                                        const struct bsdf_lanes *b)
{
    struct scatter_lanes out;
    out.dir =
        bsdf_lanes_draw(b, lanes_unit(numbers.x), lanes_unit(numbers.y), lanes_unit(numbers.z));
    const lanes_int above =
        (lanes3_dot(out.dir, b->normal) > 0.0f) & (lanes3_dot(out.dir, b->geometric) > 0.0f);
    const struct lanes3 weight = bsdf_lanes_weigh(&out.density, b, out.dir);
    out.throughput = lanes3_mul(b->throughput, weight);
    const lanes_float most = lanes3_max(out.throughput);

    // Russian roulette as there.
    lanes_float survival = (lanes_float)(1.0f);
    const lanes_int plays = place.bounce >= settings->roulette_depth;
    if (lanes_bits(plays) != 0) {
        survival = settings->quantity == QUANTITY_IRRADIANCE ? most * INV_PI : most;
        survival = plays ? lanes_min(survival, (lanes_float)(1.0f)) : (lanes_float)(1.0f);
        out.throughput = lanes3_scale(out.throughput, 1.0f / survival);
    }
    out.goes = above & (most > 0.0f) & (lanes_unit(numbers.w) < survival);
    return out;
}

// As scatter_slot(), for those of eight slots that have a bit: all may go on. Returns bits of those
// that do.
static inline uint scatter_lanes(__constant struct settings *settings, const uint bounce,
                                 const struct lanes_place place, const uint *slots, const uint bits,
                                 const struct bsdf_lanes *b, __global struct ray *restrict rays,
                                 __global struct path *restrict paths,
                                 __global const uint4 *restrict points)
{
    const struct lanes_numbers numbers = scatter_lanes_numbers(settings, place, points);
    const struct scatter_lanes next = scatter_lanes_sample(settings, place, numbers, b);
    const lanes_float next_bits =
        lanes_as_float(next.goes & (lanes_int)(int)scatter_flags(settings, bounce));
    LANES_STORE(paths, slots, .throughput_bits, bits, lanes4_make(next.throughput, next_bits));
    const uint going = bits & lanes_bits(next.goes);
    LANES_STORE(rays, slots, .dir, going, lanes4_make(next.dir, next.density));
    return going;
}

// Paths that go on, till a run of them finds its place in the next bounce's queue.
struct scatter_run {
    uint slots[SHADE_RUN];
    uint count;
};

// Hands the run to the next bounce.
static inline void scatter_run_end(struct scatter_run *run, __global struct counters *counters,
                                   const uint bounce, __global uint *restrict queue_out)
{
    if (run->count == 0)
        return;
    const uint place = atomic_add(&counters[bounce + 1].active, run->count);
    for (uint i = 0; i < run->count; i++)
        queue_out[place + i] = run->slots[i];
    run->count = 0;
}

// Sends those of eight slots on that have a bit, those together whose BSDFs are in b.
static inline void scatter_eight(
    struct scatter_run *run, __constant struct settings *settings, const struct batch batch,
    const uint bounce, const uint *slots, const uint together, const uint others,
    const struct bsdf_lanes *b, __global const struct shade *restrict shades,
    __global struct ray *restrict rays, __global struct path *restrict paths,
    __global const uint4 *restrict points, __global const uint *restrict places,
    __global struct counters *counters, __global uint *restrict queue_out)
{
    const uint alone = together & lanes_bits(b->alone); // these end here
    uint going = 0;
    if (together != alone)
        going =
            scatter_lanes(settings, bounce, lanes_place(batch, places, lanes_load(slots), bounce),
                          slots, together & ~alone, b, rays, paths, points);
    for (uint rest = others | alone; rest != 0; rest &= rest - 1) {
        const uint k = bits_lowest(rest);
        if (scatter_slot(settings, batch, bounce, slots[k], shades, rays, paths, points, places))
            going |= 1u << k;
    }
    for (; going != 0; going &= going - 1)
        run->slots[run->count++] = slots[bits_lowest(going)];
    if (run->count + LANES > SHADE_RUN)
        scatter_run_end(run, counters, bounce, queue_out);
}

#else

// Sends the path of one slot on into the next bounce's queue, if it goes on. NVIDIA's compiler
// makes one atomic of those of a warp. Groups need no other: the barriers for that would have to
// stand in loops that have none, where PoCL 3.1 compiles them wrongly.
static inline void scatter_one(
    __constant struct settings *settings, const struct batch batch, const uint bounce,
    const uint slot, __global const struct shade *restrict shades,
    __global struct ray *restrict rays, __global struct path *restrict paths,
    __global const uint4 *restrict points, __global const uint *restrict places,
    __global struct counters *counters, __global uint *restrict queue_out)
{
    if (scatter_slot(settings, batch, bounce, slot, shades, rays, paths, points, places))
        queue_out[atomic_inc(&counters[bounce + 1].active)] = slot;
}

#endif

#endif
