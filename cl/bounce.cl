// Stages 1 to 7 in one, bounce: traces a path's ray, shades and lights what it hits, and sends the
// path on; the first bounce starts it. What one stage hands to the next is read again at once,
// while it is in a cache.
//
//   in    rays, paths and queue of this bounce, or in the first camera and batch; BVH, lights
//   out   paths[slot].radiance; rays, paths and queue of the next bounce
//   next  bounce
//
// Variants: those of trace, material and direct, but for a queue, and textures that are bound.
// REGISTERS_MOST: an item takes fewer registers than the compiler would, so that more warps run
// side by side. NVIDIA's compiler heeds it where the size of groups is left open. With it an H100
// renders the Cornell box 56 % faster than by stages, which write and read twice as many bytes.

#define SHADE_LANES 0 // one path an item, on CPUs, too

#include "lib/shade_lanes.h" // first: CPUs' vectors, which others take where they need them

#include "lib/direct_hit.h"
#include "lib/material_hit.h"
#include "lib/raygen_slot.h"
#include "lib/scatter.h"
#include "lib/trace_slot.h"

#ifndef WG_BOUNCE
#define WG_BOUNCE 64 // work items in a group
#endif

#if REGISTERS_MOST
#define BOUNCE_GROUP
#else
#define BOUNCE_GROUP __attribute__((reqd_work_group_size(WG_BOUNCE, 1, 1)))
#endif

__kernel BOUNCE_GROUP void bounce(
    TRACED_PARAMETERS, __constant struct settings *settings, __constant struct camera *camera,
    const struct batch batch, const uint bounce, __global const uint *restrict triangle_emitters,
    __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict light_parents, __global const uint *restrict light_leaves,
    __global uint *queue, __global struct ray *rays, __global struct path *paths,
    __global struct shade *shades, __global struct counters *counters,
    __global const uint4 *restrict points, __global const uint *restrict places, SCATTER_PARAMETERS
#if NORMAL_MAPS
    ,
    __global const uint *restrict tangents
#endif
)
{
    TRACED_SCENE(scene);
    const struct material_scene shading = {
        scene.surface,
        triangle_emitters,
        lights,
        shapes,
        light_nodes,
        light_parents,
        light_leaves,
        points,
        places,
#if NORMAL_MAPS
        tangents
#endif
    };
    const uint i = get_global_id(0);
    if (i >= (bounce == 0 ? batch.count : counters[bounce].active))
        return; // the launch is as large as the batch, and rounded up to whole groups

    // Find what is hit.
    if (bounce == 0)
        raygen_slot(settings, camera, batch, i, rays, paths, queue, points, places);
    const uint slot = queue[i];
    const struct hit hit = trace_slot(nodes, &scene, rays, slot TRACE_PATHS_ARGUMENT);
    if (hit.triangle == HIT_NONE)
        return; // no stage sees the path again

    // Shade it.
    const struct triangle tri = triangles[hit.triangle];
    struct texture_values values;
    material_fetch(&values, texels, &materials[tri.material],
                   material_uv(&scene.surface, tri, hit));
    if (!material_hit(settings, batch, bounce, &shading, slot, hit, &values, rays, paths, shades))
        return;

    // Light it, and go on.
    const uint traced = direct_hit(nodes, &scene, settings, batch, bounce, lights, shapes,
                                   light_nodes, queue, i, rays, shades, paths, points, places);
    if (scatters != 0)
        scatter_one(settings, batch, bounce, direct_slot_again(queue, i), shades, rays, paths,
                    points, places, counters, queue_out);
    if (traced != 0)
        atomic_add(&counters[bounce].shadow_rays, traced);
}
