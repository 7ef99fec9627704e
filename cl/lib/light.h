/**
 * @file
 * Lights: which one, where on it, and how likely that was (thesis sections 2.4 and 3.4).
 */
#ifndef LIB_LIGHT_H
#define LIB_LIGHT_H

#include "lib/light_near.h"
#include "lib/surface.h"
#include "lib/texture_use.h"
#include "shared/light.h"
#include "shared/rng.h"

// What one light sends to a point, by one sample of it.
struct light_sample {
    float3 dir;       // unit, from the point to the light
    float distance;   // m
    float3 radiance;  // rgb of a surface; of a point light what stands for radiance / density
    float density;    // of the direction, 1/sr, given this light; 0: it has no area
    bool is_hittable; // a ray can hit it
};

static inline bool light_node_holds(__global const struct light_node *node, const float3 p)
{
    const float3 lo = node->lo_left.xyz;
    const float3 hi = node->hi_child.xyz;
    return p.x >= lo.x && p.y >= lo.y && p.z >= lo.z && p.x <= hi.x && p.y <= hi.y && p.z <= hi.z;
}

// Descends from the root to one light without a stack; where both children hold the point, one is
// drawn. Where the number lies in the part that it chose is the number of the next choice, with new
// bits mixed in for those used up: by itself it would run out of them in a deep tree, and some
// lights would never be drawn.
//
//   pmf   out: probability of this light
//   bits  32 random bits: their order is kept, near numbers draw near lights
// Returns the light's index, or EMITTER_NONE where no light reaches.
static inline uint light_tree_draw(float *pmf, __global const struct light_node *nodes,
                                   const float3 p, uint bits)
{
    float number = rng_unit(bits);
    *pmf = 1.0f;
    uint node = 0;
    if (!light_node_holds(&nodes[0], p))
        return EMITTER_NONE;
    for (;;) {
        const uint child = as_uint(nodes[node].hi_child.w);
        if (child & LIGHT_NODE_LEAF)
            return child & ~LIGHT_NODE_LEAF;
        const bool left = light_node_holds(&nodes[node + 1], p);
        const bool right = light_node_holds(&nodes[child], p);
        if (!left && !right)
            return EMITTER_NONE;
        bool take_left = left;
        if (left && right) {
            const float share = nodes[node].lo_left.w;
            take_left = number < share;
            bits = rng_mix(bits);
            const float rest =
                (take_left ? number : number - share) + rng_unit(bits) * RNG_UNIT_STEP;
            const float part = take_left ? share : 1.0f - share;
            number = min2(rest / part, RNG_UNIT_MAX);
            *pmf *= part;
        }
        node = take_left ? node + 1 : child;
    }
}

// The probability with which light_tree_draw() at p comes to this light: walks up from its leaf.
static inline float light_tree_pmf(__global const struct light_node *nodes,
                                   __global const uint *parents, __global const uint *leaves,
                                   const float3 p, const uint light)
{
    float pmf = 1.0f;
    uint node = leaves[light];
    if (!light_node_holds(&nodes[node], p))
        return 0.0f;
    while (node != 0) {
        const uint parent = parents[node];
        const bool is_left = node == parent + 1;
        const uint sibling = is_left ? as_uint(nodes[parent].hi_child.w) : parent + 1;
        const float share = nodes[parent].lo_left.w;
        if (light_node_holds(&nodes[sibling], p))
            pmf *= is_left ? share : 1.0f - share;
        node = parent;
    }
    return pmf;
}

// The glTF window that ends a light at its range (KHR_lights_punctual, "range").
static inline float light_window(const float distance, const float range)
{
    if (range == LIGHT_NO_RANGE)
        return 1.0f;
    const float x = distance / range;
    return max2(min2(1.0f - x * x * x * x, 1.0f), 0.0f);
}

// Emission of a triangle light at (s, t) on it, as far as it is there.
static inline float3 light_triangle_emission(const struct surface *surface, const uint triangle,
                                             const float3 factor, const float s, const float t)
{
    const struct triangle tri = surface->triangles[triangle];
    __global const struct texture_slot *slot =
        &surface->materials[tri.material].textures[TEXTURE_EMISSIVE];
    const float3 emission = factor * surface_coverage(surface, triangle, s, t);
    if (!TEXTURE_IS_USED(TEXTURE_EMISSIVE) || !(slot->flags & TEXTURE_PRESENT) ||
        max3(emission) <= 0.0f)
        return emission;
    const float4 uv = surface_blend(surface->vertices[tri.v0].uv, surface->vertices[tri.v1].uv,
                                    surface->vertices[tri.v2].uv, s, t);
    return emission * texture_fetch_pool(surface->texels, slot, uv).xyz;
}

// The place of a sample on a surface light that is not near, from two uniform numbers.
static inline float2 light_place(const uint type, const float u0, const float u1)
{
    if (type == LIGHT_TRIANGLE && u0 + u1 > 1.0f) // fold the square onto the triangle
        return (float2)(1.0f - u0, 1.0f - u1);
    if (type == LIGHT_DISC)
        return sqrt(u0) * cos_sin_turn(u1);
    return (float2)(u0, u1);
}

// Samples one light from p. Radiance is 0 where nothing comes.
//
//   normal  geometric, of the surface at p: what comes from below it does not count
//   u0, u1  uniform numbers: the place on the light
static inline struct light_sample light_sample(__global const struct light *lights,
                                               __global const struct light_shape *shapes,
                                               const uint index, const struct surface *surface,
                                               const float3 p, const float3 normal, const float u0,
                                               const float u1)
{
    const struct light light = lights[index];
    const uint kind = as_uint(light.color_kind.w);
    const uint type = kind & LIGHT_TYPE_MASK;
    struct light_sample out;
    out.radiance = (float3)(0.0f);
    out.density = 0.0f;
    out.is_hittable = false;

    // Find the point on the light.
    struct light_shape shape;
    float2 place = (float2)(0.0f);
    float angle = 0.0f;  // of a light that is near
    float height = 0.0f; // of p over the side that emits, m
    float3 way = light.org_range.xyz - p;
    if (type != LIGHT_POINT)
        shape = shapes[kind >> LIGHT_SHAPE_SHIFT];
    if (type > LIGHT_SPOT) {
        height = -dot(normalize(cross(shape.edge_u.xyz, shape.edge_v.xyz)), way);
        if (kind & LIGHT_TWO_SIDED)
            height = fabs(height);
        place = light_place(type, u0, u1);
        if (height > 0.0f && !light_is_below(normal, way, shape.edge_u.xyz, shape.edge_v.xyz))
            angle = light_near_draw(&place, type, way, shape.edge_u.xyz, shape.edge_v.xyz, u0, u1);
        way += place.x * shape.edge_u.xyz + place.y * shape.edge_v.xyz;
    }
    const float distance2 = dot(way, way);
    out.distance = sqrt(distance2);
    out.dir = way / out.distance;
    if (!(distance2 > 0.0f))
        return out;

    switch (type) {
    case LIGHT_POINT:
        out.radiance =
            light.color_kind.xyz * (light_window(out.distance, light.org_range.w) / distance2);
        break;
    case LIGHT_SPOT: {
        const float cone =
            clamp(-dot(out.dir, shape.edge_u.xyz) * shape.edge_u.w + shape.edge_v.w, 0.0f, 1.0f);
        out.radiance = light.color_kind.xyz *
                       (cone * cone * light_window(out.distance, light.org_range.w) / distance2);
        break;
    }
    default: {
        if (!(height > 0.0f))
            return out;
        const uint triangle = as_uint(shape.edge_v.w);
        out.density =
            angle > 0.0f ? 1.0f / angle : distance2 * out.distance / (height * shape.edge_u.w);
        out.is_hittable = triangle != EMITTER_NONE;
        out.radiance =
            type == LIGHT_TRIANGLE
                ? light_triangle_emission(surface, triangle, light.color_kind.xyz, place.x, place.y)
                : light.color_kind.xyz;
        break;
    }
    }
    return out;
}

// The density, 1/sr, with which light_sample() at p draws the direction of a ray from there that
// hits a surface light.
//
//   distance  of the hit, m
//   cosine    there, between ray and normal, > 0
static inline float light_hit_density(__global const struct light *lights,
                                      __global const struct light_shape *shapes, const uint index,
                                      const float3 p, const float distance, const float cosine)
{
    const struct light light = lights[index];
    const uint kind = as_uint(light.color_kind.w);
    const struct light_shape shape = shapes[kind >> LIGHT_SHAPE_SHIFT];
    const struct light_near near = light_near_make(kind & LIGHT_TYPE_MASK, light.org_range.xyz - p,
                                                   shape.edge_u.xyz, shape.edge_v.xyz);
    return near.angle > 0.0f ? 1.0f / near.angle : distance * distance / (shape.edge_u.w * cosine);
}

#endif
