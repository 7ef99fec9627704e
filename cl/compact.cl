// Stage 8, compact: the paths that go on become the next bounce's queue, in their order.
//
//   in    queue, paths
//   out   queue_out, counters[bounce + 1].active
//   next  trace
//
// count, scan, scatter over tiles (lib/scan.h).

#include "lib/scan.h"
#include "shared/path.h"

// Whether the path in a slot has a ray to trace.
static inline uint compact_keeps(__global const struct path *paths, const uint slot)
{
    return (as_uint(paths[slot].throughput_bits.w) & PATH_ALIVE) ? 1u : 0u;
}

// Counts what each tile keeps.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void compact_count(
    __global const struct counters *counters, const uint bounce,
    __global const uint *restrict queue, __global const struct path *restrict paths,
    __global uint *restrict totals)
{
    __local uint counts[WG_SCAN];
    const uint item = get_local_id(0);
    const uint count = counters[bounce].active;
    const uint tile_count = (count + SCAN_TILE - 1) / SCAN_TILE;
    for (uint tile = get_group_id(0); tile < tile_count; tile += get_num_groups(0)) {
        const uint first = tile * SCAN_TILE + item * SCAN_RUN;
        const uint end = min(first + SCAN_RUN, count);
        uint kept = 0;
        for (uint i = first; i < end; i++)
            kept += compact_keeps(paths, queue[i]);
        counts[item] = kept;
        const uint total = scan_group(counts);
        if (item == 0)
            totals[tile] = total;
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

// Turns the totals into the places where each tile's start, and counts them all. One group.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void compact_scan(
    __global struct counters *counters, const uint bounce, __global uint *totals)
{
    __local uint values[WG_SCAN];
    const uint count = counters[bounce].active;
    const uint kept = scan_array(totals, (count + SCAN_TILE - 1) / SCAN_TILE, values);
    if (get_local_id(0) == 0)
        counters[bounce + 1].active = kept;
}

// Writes the kept slots.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void compact_scatter(
    __global const struct counters *counters, const uint bounce,
    __global const uint *restrict queue, __global const struct path *restrict paths,
    __global const uint *restrict totals, __global uint *restrict queue_out)
{
    __local uint places[WG_SCAN];
    const uint item = get_local_id(0);
    const uint count = counters[bounce].active;
    const uint tile_count = (count + SCAN_TILE - 1) / SCAN_TILE;
    for (uint tile = get_group_id(0); tile < tile_count; tile += get_num_groups(0)) {
        const uint first = tile * SCAN_TILE + item * SCAN_RUN;
        const uint end = min(first + SCAN_RUN, count);
        uint kept = 0;
        for (uint i = first; i < end; i++)
            kept += compact_keeps(paths, queue[i]);
        places[item] = kept;
        scan_group(places);
        uint place = totals[tile] + places[item];
        for (uint i = first; i < end; i++) {
            const uint slot = queue[i];
            if (compact_keeps(paths, slot))
                queue_out[place++] = slot;
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}
