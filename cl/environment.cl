// Stage 2b, environment: rays that met nothing collect what comes from far away. Enqueued only
// where there is an environment.
//
//   in    hits, rays, paths, queue of this bounce, environment
//   out   paths[slot].radiance
//   next  sort or material

#include "lib/environment.h"
#include "shared/path.h"
#include "shared/ray.h"
#include "shared/settings.h"

#ifndef WG_ENVIRONMENT
#define WG_ENVIRONMENT 64 // work items in a group
#endif

__kernel __attribute__((reqd_work_group_size(WG_ENVIRONMENT, 1, 1))) void environment(
    __constant struct settings *settings, const struct environment_map map, const uint bounce,
    __global const struct counters *counters, __global const float4 *restrict texels,
    __global const uint *restrict queue, __global const struct hit *restrict hits,
    __global const struct ray *restrict rays, __global struct path *restrict paths)
{
    const uint count = counters[bounce].active;
    if (settings->quantity == QUANTITY_IRRADIANCE && bounce == 0)
        return; // it is measured on surfaces
    for (uint i = get_global_id(0); i < count; i += get_global_size(0)) {
        const uint slot = queue[i];
        if (hits[slot].triangle != HIT_NONE)
            continue;
        const float4 dir = rays[slot].dir;
        const float2 place = environment_place(map, dir.xyz);
        const float3 radiance = environment_radiance(map, texels, place);
        const float4 throughput_bits = paths[slot].throughput_bits;
        float weight = 1.0f; // against light samples, unless none could have met this ray
        if (!(as_uint(throughput_bits.w) & PATH_SPECULAR))
            weight = mis_weight(dir.w, environment_density(map, texels, place));
        paths[slot].radiance_normal.xyz += throughput_bits.xyz * radiance * weight;
    }
}
