// Stage 6, directional: light from directional lights at every shaded hit, one shadow ray each.
//
//   in    shades, queue of this bounce, directional lights, BVH
//   out   paths[slot].radiance
//   next  compact
//
// Variants: those of trace.

#include "lib/bsdf.h"
#include "lib/queue.h"
#include "lib/traverse.h"
#include "shared/light.h"
#include "shared/settings.h"

__kernel __attribute__((reqd_work_group_size(WG_TRACE, 1, 1))) void directional(
    BVH_NODES nodes, __global const struct woop *restrict woop, __global const uint *restrict refs,
    __global const struct vertex *vertices, __global const uint2 *colors,
    __global const struct triangle *triangles, __global const struct material *materials,
    __global const uint *texels, __constant struct settings *settings, const uint bounce,
    __global const struct directional_light *restrict lights, __global const uint *restrict queue,
    __global const struct hit *restrict hits, __global const struct shade *restrict shades,
    __global struct path *restrict paths, __global struct counters *counters)
{
    struct surface surface;
    surface.vertices = vertices;
    surface.colors = colors;
    surface.triangles = triangles;
    surface.materials = materials;
    surface.texels = texels;

    const uint light_count = settings->directional_count;
    const uint count = counters[bounce].active;
    uint traced = 0; // shadow rays of this work item
    QUEUE_LOCAL(run);
    for (uint i = queue_first(&counters[bounce].directional_head, run); queue_group(i) < count;
         i = queue_next(i, &counters[bounce].directional_head, run)) {
        if (i >= count)
            continue;
        const uint slot = queue[i];
        if (hits[slot].triangle == HIT_NONE || !(shades[slot].flags & SHADE_ACTIVE))
            continue;
        const struct bsdf b = bsdf_load(&shades[slot]);
        const float3 p = shades[slot].org_normal.xyz;

        float3 sum = (float3)(0.0f); // over the lights
        for (uint k = 0; k < light_count; k++) {
            const float3 dir = -lights[k].dir.xyz;
            float density; // no bounce can meet a light without extent
            const float3 value = bsdf_eval(&density, &b, dir) * lights[k].color.xyz;
            if (max3(value) <= 0.0f)
                continue;
            traced++;
            sum += value * traverse_light(nodes, woop, refs, &surface, p, dir, FLT_MAX);
        }
        paths[slot].radiance_flags.xyz += shades[slot].throughput_f.xyz * sum;
    }
    if (traced != 0)
        atomic_add(&counters[bounce].shadow_rays, traced);
}
