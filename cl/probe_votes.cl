// No stage: whether this device's compiler takes lib/warp.h and lib/word_stack.h, and is to be told
// how many registers an item takes, REGISTERS_MOST. It is built, and never run.

#define WARP_VOTES 1

#include "lib/word_stack.h"

__kernel __attribute__((reqd_work_group_size(WARP_LANES, 1, 1))) void probe_votes(
    __global uint *restrict out)
{
    const uint lane = get_local_id(0);
    const uint first = warp_first(lane + 1);
    int entries[2];
    stack_top top = stack_begin(entries, 0);
    stack_push(entries, &top, 1, warp_count(lane == first) == 1);
    out[lane] = (uint)stack_pop(entries, &top, 0, lane < first);
}
