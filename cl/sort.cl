// Stage 3, sort: the queue's slots in the order of the materials they hit, misses last.
//
//   in    queue, hits
//   out   order, ranges: material m has order[ranges[m] .. ranges[m + 1]); flags of paths that
//   missed next  material
//
// A least-significant-digit radix sort (thesis section 3.3), SORT_BITS a round; each round is
// count, scan, scatter. It is stable, so that the Z-order of the queue lives on within a material.
// keys starts the first round; ranges follows the last.

#include "lib/scan.h"
#include "shared/geometry.h"
#include "shared/path.h"
#include "shared/ray.h"

#define SORT_BITS   4u
#define SORT_DIGITS 16u

// Reads the keys: the material of each slot's hit, material_count for a miss, whose path ends: no
// launch of material sees it.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void sort_keys(
    __global const struct counters *counters, const uint bounce,
    __global const uint *restrict queue, __global const struct hit *restrict hits,
    __global const struct triangle *restrict triangles, const uint material_count,
    __global uint *restrict keys, __global uint *restrict slots, __global struct path *paths)
{
    const uint count = counters[bounce].active;
    for (uint i = get_global_id(0); i < count; i += get_global_size(0)) {
        const uint slot = queue[i];
        const uint triangle = hits[slot].triangle;
        if (triangle == HIT_NONE)
            paths[slot].throughput_bits.w = as_float(0u);
        keys[i] = triangle == HIT_NONE ? material_count : triangles[triangle].material;
        slots[i] = slot;
    }
}

// Counts the digits of each tile: totals[digit * tile_count + tile].
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void sort_count(
    __global const struct counters *counters, const uint bounce, const uint shift,
    __global const uint *restrict keys, __global uint *restrict totals)
{
    __local uint counts[SORT_DIGITS * WG_SCAN]; // [digit][item]
    const uint item = get_local_id(0);
    const uint count = counters[bounce].active;
    const uint tile_count = (count + SCAN_TILE - 1) / SCAN_TILE;
    for (uint tile = get_group_id(0); tile < tile_count; tile += get_num_groups(0)) {
        for (uint d = 0; d < SORT_DIGITS; d++)
            counts[d * WG_SCAN + item] = 0;
        const uint first = tile * SCAN_TILE + item * SCAN_RUN;
        const uint end = min(first + SCAN_RUN, count);
        for (uint i = first; i < end; i++)
            counts[((keys[i] >> shift) & (SORT_DIGITS - 1)) * WG_SCAN + item]++;
        barrier(CLK_LOCAL_MEM_FENCE);
        for (uint d = item; d < SORT_DIGITS; d += WG_SCAN) {
            uint sum = 0;
            for (uint j = 0; j < WG_SCAN; j++)
                sum += counts[d * WG_SCAN + j];
            totals[d * tile_count + tile] = sum;
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

// Turns the totals into the places where each digit of each tile starts. One group.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void sort_scan(
    __global const struct counters *counters, const uint bounce, __global uint *totals)
{
    __local uint values[WG_SCAN];
    const uint count = counters[bounce].active;
    const uint tile_count = (count + SCAN_TILE - 1) / SCAN_TILE;
    scan_array(totals, SORT_DIGITS * tile_count, values);
}

// Moves every element to its place.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void sort_scatter(
    __global const struct counters *counters, const uint bounce, const uint shift,
    __global const uint *restrict keys, __global const uint *restrict slots,
    __global const uint *restrict totals, __global uint *restrict keys_out,
    __global uint *restrict slots_out)
{
    __local uint places[SORT_DIGITS * WG_SCAN]; // [digit][item] next place of the item's digit
    const uint item = get_local_id(0);
    const uint count = counters[bounce].active;
    const uint tile_count = (count + SCAN_TILE - 1) / SCAN_TILE;
    for (uint tile = get_group_id(0); tile < tile_count; tile += get_num_groups(0)) {
        // Count each item's digits.
        for (uint d = 0; d < SORT_DIGITS; d++)
            places[d * WG_SCAN + item] = 0;
        const uint first = tile * SCAN_TILE + item * SCAN_RUN;
        const uint end = min(first + SCAN_RUN, count);
        for (uint i = first; i < end; i++)
            places[((keys[i] >> shift) & (SORT_DIGITS - 1)) * WG_SCAN + item]++;
        barrier(CLK_LOCAL_MEM_FENCE);

        // Start every digit where the tile's place says, items in order.
        for (uint d = item; d < SORT_DIGITS; d += WG_SCAN) {
            uint before = totals[d * tile_count + tile];
            for (uint j = 0; j < WG_SCAN; j++) {
                const uint mine = places[d * WG_SCAN + j];
                places[d * WG_SCAN + j] = before;
                before += mine;
            }
        }
        barrier(CLK_LOCAL_MEM_FENCE);

        // Move the item's run.
        for (uint i = first; i < end; i++) {
            const uint key = keys[i];
            const uint place = places[((key >> shift) & (SORT_DIGITS - 1)) * WG_SCAN + item]++;
            keys_out[place] = key;
            slots_out[place] = slots[i];
        }
        barrier(CLK_LOCAL_MEM_FENCE);
    }
}

// Finds where each material starts in the sorted keys; ranges[material_count] is the first miss.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void sort_ranges(
    __global const struct counters *counters, const uint bounce, __global const uint *restrict keys,
    const uint material_count, __global uint *restrict ranges)
{
    const uint count = counters[bounce].active;
    for (uint m = get_global_id(0); m <= material_count; m += get_global_size(0)) {
        // The first key that is not below m, by halving.
        uint lo = 0;
        uint hi = count;
        while (lo < hi) {
            const uint middle = (lo + hi) / 2;
            if (keys[middle] < m)
                lo = middle + 1;
            else
                hi = middle;
        }
        ranges[m] = lo;
    }
}
