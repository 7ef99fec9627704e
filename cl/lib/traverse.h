/**
 * @file
 * One ray through the scene, by whichever BVH kernels are built for: BVH_WIDE takes the 8-wide one
 * (lib/traverse_wide.h), BVH_QUAD the 4-wide one (lib/traverse_quad.h), BVH_COMPRESSED the
 * compressed one (lib/traverse_compressed.h), else it is the binary one (lib/traverse_binary.h).
 * All define
 *
 *     struct hit traverse_through(nodes, scene, org, dir, tmin, tmax, any_hit, passage, mode)
 *
 *   tmin     0 at least
 *   any_hit  constant: true: some hit, as soon as there is one, of which with TRACED_KEEPS nothing
 *            is told but that its triangle is not HIT_NONE; false: the nearest
 *   passage  what the mode, a constant PASSAGE_..., asks of surfaces that let light by; they are
 *            asked only where a reference is BVH_REF_ALPHA
 */
#ifndef LIB_TRAVERSE_H
#define LIB_TRAVERSE_H

#include "lib/leaf.h" // here, since each file is embedded where it is included first
#include "lib/slab.h"

#if BVH_WIDE
#include "lib/traverse_wide.h"
#elif BVH_QUAD || BVH_COMPRESSED
#include "lib/walk.h"
#else
#include "lib/traverse_binary.h"
#endif

// What every kernel that traces takes first; on the host's side, ARGS_TRACED in
// pipeline/stages.h.
#define TRACED_PARAMETERS                                                                          \
    BVH_NODES nodes, __global const float4 *restrict woop, __global const uint *restrict refs,     \
        __global const struct vertex *vertices, __global const uint2 *colors,                      \
        __global const struct triangle *triangles, __global const struct material *materials,      \
        __global const uint *texels

// Makes these parameters, nodes apart, one thing: nodes may be an image, which no struct holds.
// With TRACED_KEEPS, what has stopped rays lives as long as it does.
#if TRACED_KEEPS
#define TRACED_SCENE(name)                                                                         \
    struct occluders name##_kept;                                                                  \
    occluders_begin(&name##_kept);                                                                 \
    const struct traced name = {                                                                   \
        woop, refs, {vertices, colors, triangles, materials, texels}, &name##_kept}
#else
#define TRACED_SCENE(name)                                                                         \
    const struct traced name = {woop, refs, {vertices, colors, triangles, materials, texels}}
#endif

// As traverse_through(), by chance.
static inline struct hit traverse(BVH_NODES nodes, const struct traced *scene, const float3 org,
                                  const float3 dir, const float tmin, const float tmax,
                                  const bool any_hit)
{
    struct passage passage;
    passage_init(&passage);
    return traverse_through(nodes, scene, org, dir, tmin, tmax, any_hit, &passage, PASSAGE_CHANCE);
}

// The share of light that comes from up to tmax along the ray, for each colour.
static inline float3 traverse_light(BVH_NODES nodes, const struct traced *scene, const float3 org,
                                    const float3 dir, const float tmax)
{
    struct passage passage;
    passage_init(&passage);
    const struct hit blocker =
        traverse_through(nodes, scene, org, dir, 0.0f, tmax, true, &passage, PASSAGE_SHARE);
    return blocker.triangle == HIT_NONE ? passage.share : (float3)(0.0f);
}

#endif
