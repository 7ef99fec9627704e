// Stage 2, trace: the nearest hit of every active ray.
//
//   in    rays and queue of this bounce, BVH
//   out   hits[slot]; with LAYERS and ALPHA, paths[slot].throughput of rays through coloured panes
//   next  sort
//
// Variants: PERSISTENT fetches work from counters.trace_head (lib/queue.h), with BVH_QUAD and
// WARP_VOTES lane by lane (lib/trace_refill.h), else one ray an item; RAY_SPANS: rays carry how
// near and how far they look, else they look ahead without end; NODES_IMAGE reads nodes through a
// 1D texture; ALPHA asks materials whether they let a ray by, LAYERS also those that are thin and
// smooth; ANY_HIT: whether there is a hit, of any triangle: hits[slot].triangle is 0 or HIT_NONE.
//
// trace_packets does the same for rays that run alike, on CPUs: neighbours in the queue go together
// (lib/traverse_packet.h). trace_few does so where there are few triangles (lib/traverse_few.h).

// Groups of one warp free their place at once: an H100 traces primary rays in Sponza at 6 to 9 %
// more rays/s than in groups of two, bounces at 0 to 6 % more, and any hit over the binary BVH at 4
// % fewer.
#if WARP_VOTES && !PERSISTENT && !ANY_HIT
#define WG_TRACE 32
#endif

#include "lib/lanes_most.h"
#include "lib/queue.h"
#include "lib/trace_slot.h"
#include "lib/trace_refill.h"

// What both kernels take.
#define TRACE_PARAMETERS                                                                           \
    TRACED_PARAMETERS, __global const struct ray *restrict rays,                                   \
        __global const uint *restrict queue, __global struct hit *restrict hits,                   \
        __global struct counters *counters, const uint bounce

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void trace(
    TRACE_PARAMETERS TRACE_PATHS)
{
    TRACED_SCENE(scene);
    const uint count = counters[bounce].active;
#if TRACE_REFILLS
    trace_refilling(nodes, &scene, rays, queue, hits, &counters[bounce].trace_head, count, TRACE_ANY
#if ALPHA && LAYERS
                    ,
                    paths
#endif
    );
#else
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].trace_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].trace_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        const struct hit hit = trace_slot(nodes, &scene, rays, slot TRACE_PATHS_ARGUMENT);
        if (TRACE_ANY) // which one and where was not asked
            hits[slot].triangle = hit.triangle == HIT_NONE ? HIT_NONE : 0;
        else
            hits[slot] = hit;
    }
#endif
}

#if DEVICE_CPU && BVH_WIDE && !ANY_HIT

#include "lib/traverse_packet.h"

// One packet a group: PoCL keeps what each item of a larger one has on its stack apart.
__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void trace_packets(
    TRACE_PARAMETERS TRACE_PATHS)
{
    TRACED_SCENE(scene);
    const uint count = counters[bounce].active;
    const uint first = get_global_id(0) * RAY_PACKET;
    if (first >= count)
        return;                                      // the launch is as large as the batch
    const uint own = min(count - first, RAY_PACKET); // rays; the last one fills the packet up

    // Put the rays side by side.
    float rows[8][RAY_PACKET];
    for (uint k = 0; k < RAY_PACKET; k++) {
        const struct ray ray = trace_load(rays, queue[first + min(k, own - 1)]);
        rows[0][k] = ray.org.x;
        rows[1][k] = ray.org.y;
        rows[2][k] = ray.org.z;
        rows[3][k] = ray.org.w;
        rows[4][k] = ray.dir.x;
        rows[5][k] = ray.dir.y;
        rows[6][k] = ray.dir.z;
        rows[7][k] = ray.dir.w;
    }
    struct packet packet;
    packet.org_x = vload16(0, rows[0]);
    packet.org_y = vload16(0, rows[1]);
    packet.org_z = vload16(0, rows[2]);
    packet.tmin = vload16(0, rows[3]);
    packet.dir_x = vload16(0, rows[4]);
    packet.dir_y = vload16(0, rows[5]);
    packet.dir_z = vload16(0, rows[6]);
    packet.t = vload16(0, rows[7]);
    packet.u = (float16)(0.0f);
    packet.v = (float16)(0.0f);
    packet.ref = (uint16)(HIT_NONE);

    // Trace those of one octant together.
    const int16 octants =
        ((packet.dir_x < 0.0f) & 1) | ((packet.dir_y < 0.0f) & 2) | ((packet.dir_z < 0.0f) & 4);
    int octant[RAY_PACKET];
    uint tinted = 0; // rays that have gone through something coloured
    vstore16(octants, 0, octant);
    for (uint rest = 0xffffu; rest != 0; rest &= ~bits16(packet.active)) {
        const uint k = bits_lowest(rest);
        packet.active = octants == octant[k];
        traverse_packet(&tinted, &packet, nodes, &scene,
                        (float3)(rows[4][k], rows[5][k], rows[6][k]));
    }

    // Write their hits.
    uint found[RAY_PACKET];
    vstore16(packet.t, 0, rows[0]);
    vstore16(packet.u, 0, rows[1]);
    vstore16(packet.v, 0, rows[2]);
    vstore16(packet.ref, 0, found);
    for (uint k = 0; k < own; k++) {
        const uint slot = queue[first + k];
        struct hit hit;
        hit.t = rows[0][k];
        hit.u = rows[1][k];
        hit.v = rows[2][k];
        hit.triangle = found[k];
        hits[slot] = traced_name(hit, &scene);
#if TRACE_TINTS
        if (tinted & (1u << k))
            trace_tint(nodes, &scene, trace_load(rays, slot), hit.t, &paths[slot]);
#endif
    }
}

#endif

#if DEVICE_CPU && BVH_WIDE && !ANY_HIT && !ALPHA

#include "lib/shade_lanes.h"
#include "lib/traverse_few.h"

__kernel __attribute__((reqd_work_group_size(1, 1, 1))) void trace_few(TRACE_PARAMETERS,
                                                                       const uint block_count)
{
    struct few few;
    const uint count = counters[bounce].active;
    if (get_global_id(0) * SHADE_RUN >= count)
        return; // the launch is as large as the batch
    few_begin(&few, woop, refs, block_count);
    SHADE_LANES_LOOP(i, count)
    {
        uint slots[LANES];
        const uint used = shade_lanes_slots(slots, queue, i, count);
        const struct lanes4 org = LANES_OF(rays, slots, .org);
        const struct lanes4 dir = LANES_OF(rays, slots, .dir);
#if RAY_SPANS
        const lanes_float tmin = org.w;
        struct few_hits found = few_hits_begin(dir.w);
#else
        const lanes_float tmin = (lanes_float)(0.0f);
        struct few_hits found = few_hits_begin((lanes_float)(FLT_MAX));
#endif
        traverse_few(&found, &few, lanes3_xyz(org), lanes3_xyz(dir), tmin, false);
        LANES_STORE(((__global float4 *)hits), slots, , used, few_name(&found, &few));
    }
}

#endif
