/**
 * @file
 * A ray's way through a layout of the BVH that can be left and taken up again. Such layouts
 * define, beside BVH_NODES,
 *
 *     struct walk                 where a ray is; it has hit, org, dir and tmin
 *     WALK_STACK(name)            declares what else it keeps
 *     walk_begin(&walk, name, org, dir, tmin, tmax)
 *     walk_go(&walk, name, nodes, scene, any_hit, passage, mode, few)
 *                                 walks on, to the end or until fewer than `few` lanes of the warp
 *                                 walk; 0: to the end
 *     walk_is_done(&walk)
 *     walk_idle(&walk)            makes one that is done, of no ray
 *     WALK_FEW                    lanes, below which it pays to fetch new rays
 */
#ifndef LIB_WALK_H
#define LIB_WALK_H

#include "lib/byte_planes.h" // here, since each file is embedded where it is included first
#include "lib/word_stack.h"

#if BVH_COMPRESSED
#include "lib/traverse_compressed.h"
#else
#include "lib/traverse_quad.h"
#endif

// Finds what the ray hits between tmin, 0 at least, and tmax (lib/traverse.h).
static inline struct hit traverse_through(BVH_NODES nodes, const struct traced *scene,
                                          const float3 org, const float3 dir, const float tmin,
                                          const float tmax, const bool any_hit,
                                          struct passage *passage, const int mode)
{
    struct walk walk;
    WALK_STACK(stack);
    walk_begin(&walk, stack, org, dir, tmin, tmax);
    walk_go(&walk, stack, nodes, scene, any_hit, passage, mode, 0);
    return traced_name(walk.hit, scene);
}

#endif
