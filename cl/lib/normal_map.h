/**
 * @file
 * Normal maps. lib/material_lanes.h does the same
 * for hits side by side.
 */
#ifndef LIB_NORMAL_MAP_H
#define LIB_NORMAL_MAP_H

#include "lib/bsdf.h"
#include "lib/surface.h"

#if NORMAL_MAPS

static inline float3 normal_map_tangent(const uint packed)
{
    return normalize(oct_unpack(packed & ~OCT_FLAG).xyz);
}

// The shading normal that a normal map makes of the interpolated one; the latter where the map's
// looks away from the viewer.
//
//   b       its normal is the interpolated one, viewer's side
//   scale   of the map's x and y
//   texel   the map's, 0 .. 1
//   front   the viewer's side is the front
static inline float3 normal_map_apply(const struct bsdf *b, const float scale, const float3 texel,
                                      const bool front, __global const uint *restrict tangents,
                                      const struct triangle tri, const float u, const float v)
{
    // The frame is that of the front.
    const float3 normal = front ? b->normal : -b->normal;
    const uint packed = tangents[tri.v0];
    const float3 tangent = (1.0f - u - v) * normal_map_tangent(packed) +
                           u * normal_map_tangent(tangents[tri.v1]) +
                           v * normal_map_tangent(tangents[tri.v2]);
    const float3 flat = tangent - dot(tangent, normal) * normal;
    if (dot(flat, flat) < 1e-12f)
        return b->normal;
    const float3 t = normalize(flat);
    const float3 bitangent = (packed & OCT_FLAG) ? cross(t, normal) : cross(normal, t);

    const float2 slope = (2.0f * texel.xy - 1.0f) * scale;
    const float3 bent = slope.x * t + slope.y * bitangent + (2.0f * texel.z - 1.0f) * normal;
    if (!(dot(bent, bent) > 1e-12f))
        return b->normal;
    const float3 mapped = front ? normalize(bent) : -normalize(bent);
    return dot(mapped, b->view) > 1e-4f ? mapped : b->normal;
}

#endif
#endif
