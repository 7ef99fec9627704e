/**
 * @file
 * The size of a group of a kernel that lights hits, for lib/queue.h.
 */
#ifndef LIB_LIGHT_GROUP_H
#define LIB_LIGHT_GROUP_H

#include "lib/shade_lanes.h"

// To draw a shadow ray takes twice the registers that it takes to follow one, and with those an
// NVIDIA unit holds a quarter of its warps. No barrier is in the loop of persistent warps, so that
// groups may be as large as they come: one that fills the unit must make do with 64 registers, and
// what is spilt for that stays in the first cache. An H100 renders Sponza 7 % faster than by groups
// of two warps with registers at will, Sibenik 13 %, and 29 % where lights are drawn by importance;
// of 640 items, with 96 registers, 4, 8 and 23 %. The Cornell box loses 22 % by it, and is traced
// otherwise: its rays are short. Lanes that went on to further hits until one needed a ray lost the
// order of the next queue, and with it more than they gained.
#if SHADE_LANES
#define WG_TRACE 1 // an item takes a run
#elif PERSISTENT && WARP_VOTES
#define WG_TRACE 1024
#endif

#endif
