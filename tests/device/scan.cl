// lib/scan.h by itself.

#include "lib/scan.h"

// out: items of a group, elements of an item, elements of a group.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void scan_sizes(__global uint *out)
{
    if (get_global_id(0) == 0) {
        out[0] = WG_SCAN;
        out[1] = SCAN_RUN;
        out[2] = SCAN_TILE;
    }
}

// Scans the WG_SCAN values of each group; totals[group] is their sum.
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void scan_groups(
    __global uint *values, __global uint *totals)
{
    __local uint shared[WG_SCAN];
    shared[get_local_id(0)] = values[get_global_id(0)];
    const uint total = scan_group(shared);
    values[get_global_id(0)] = shared[get_local_id(0)];
    if (get_local_id(0) == 0)
        totals[get_group_id(0)] = total;
}

// Scans values[0 .. count) by one group; every item writes the sum to totals[item].
__kernel __attribute__((reqd_work_group_size(WG_SCAN, 1, 1))) void scan_whole(__global uint *values,
                                                                              const uint count,
                                                                              __global uint *totals)
{
    __local uint shared[WG_SCAN];
    totals[get_local_id(0)] = scan_array(values, count, shared);
}
