/**
 * @file
 * Normal maps.
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
//   texel   the map's, 0 .. 1
//   front   the viewer's side is the front
static inline float3 normal_map_apply(const struct bsdf *b,
                                      __global const struct material *material, const float3 texel,
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

    const float2 slope = (2.0f * texel.xy - 1.0f) * material->normal_scale;
    const float3 bent = slope.x * t + slope.y * bitangent + (2.0f * texel.z - 1.0f) * normal;
    if (!(dot(bent, bent) > 1e-12f))
        return b->normal;
    const float3 mapped = front ? normalize(bent) : -normalize(bent);
    return dot(mapped, b->view) > 1e-4f ? mapped : b->normal;
}

// The shading normal turned towards the geometric one until what is mirrored at it stays above the
// surface: a metal would be black there.
static inline float3 normal_map_bend(const struct bsdf *b)
{
    const float3 mirrored = 2.0f * dot(b->normal, b->view) * b->normal - b->view;
    const float view_z = dot(b->view, b->geometric);
    const float least = min2(0.9f * view_z, 0.025f); // cosine of the mirrored view
    if (dot(mirrored, b->geometric) >= least)
        return b->normal;

    // In the plane of both normals, z along the geometric one: 2 (N V) Nz - Vz = least, which
    // squared is quadratic in Nz^2.
    const float3 across = b->normal - dot(b->normal, b->geometric) * b->geometric;
    if (dot(across, across) < 1e-12f)
        return b->geometric;
    const float3 x = normalize(across);
    const float view_x = dot(b->view, x);
    const float a = max2(view_x * view_x + view_z * view_z, 1e-12f);
    const float half_b = a + view_z * least;
    const float c = (least + view_z) * (least + view_z);
    const float root = sqrt(max2(half_b * half_b - a * c, 0.0f));
    const float z2 = clamp(0.5f * (half_b + (view_x < 0.0f ? root : -root)) / a, 0.0f, 1.0f);
    const float3 bent = sqrt(1.0f - z2) * x + sqrt(z2) * b->geometric;
    return dot(bent, b->view) > 1e-4f ? bent : b->geometric;
}

#endif
#endif
