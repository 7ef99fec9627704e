/**
 * @file
 * light_sample() of lib/light.h for eight paths side by side.
 */
#ifndef LIB_LIGHT_LANES_H
#define LIB_LIGHT_LANES_H

#include "lib/lanes.h"
#include "lib/light.h"

// struct light_sample, lane by lane.
struct light_lanes {
    struct lanes3 dir, radiance;
    float8 distance, density;
    int8 is_hittable;
};

// What triangles of `bits` emit, where their materials have to be asked.
static inline struct lanes3 light_lanes_emission(const struct surface *surface, uint bits,
                                                 const uint8 triangle, const struct lanes3 color,
                                                 const float8 s, const float8 t)
{
    uint triangles[LANES];
    float u[LANES], v[LANES], r[LANES], g[LANES], b[LANES];
    struct lanes3 out = color;
    vstore8(triangle, 0, triangles);
    vstore8(s, 0, u);
    vstore8(t, 0, v);
    vstore8(color.x, 0, r);
    vstore8(color.y, 0, g);
    vstore8(color.z, 0, b);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = lanes_lowest(bits);
        const float3 emission =
            light_triangle_emission(surface, triangles[k], (float3)(r[k], g[k], b[k]), u[k], v[k]);
        out = lanes3_put(out, k, emission);
    }
    return out;
}

// The glTF window that ends lights at their ranges: light_window().
static inline float8 light_lanes_window(const float8 distance, const float8 range)
{
    const float8 x = distance / range;
    const float8 window = max8(1.0f - x * x * x * x, (float8)(0.0f));
    return range == LIGHT_NO_RANGE ? (float8)(1.0f) : window;
}

// Which lights are near enough for light_near_make() to look at them, with the same rule.
static inline int8 light_lanes_are_near(const int8 type, const struct lanes3 corner,
                                        const struct lanes3 edge_u, const struct lanes3 edge_v)
{
    const struct lanes3 diagonal = lanes3_add(edge_u, edge_v);
    const struct lanes3 middle = lanes3_muladd(diagonal, (float8)(0.5f), corner);
    const float8 radius2 = 0.25f * (lanes3_dot(edge_u, edge_u) + lanes3_dot(edge_v, edge_v));
    return ((type == LIGHT_TRIANGLE) | (type == LIGHT_RECTANGLE)) &
           (lanes3_dot(middle, middle) < LIGHT_NEAR_SPHERES * radius2);
}

// light_is_below()
static inline int8 light_lanes_are_below(const struct lanes3 normal, const struct lanes3 corner,
                                         const struct lanes3 edge_u, const struct lanes3 edge_v)
{
    const float8 zero = (float8)(0.0f);
    return lanes3_dot(normal, corner) + max8(lanes3_dot(normal, edge_u), zero) +
               max8(lanes3_dot(normal, edge_v), zero) <
           0.0f;
}

// light_near_draw() of those lanes that have a bit. Returns the lights' solid angles, 0 of others.
//
//   s, t    in, out: places along the lights' edges
//   corner  of the lights, from the points
static inline float8 light_lanes_draw_near(float8 *s, float8 *t,
                                           __global const struct light *lights,
                                           __global const struct light_shape *shapes,
                                           const uint *index, uint bits, const struct lanes3 corner,
                                           const float8 u0, const float8 u1)
{
    float x[LANES], y[LANES], z[LANES], u[LANES], v[LANES];
    float place_s[LANES], place_t[LANES], angle[LANES];
    vstore8(corner.x, 0, x);
    vstore8(corner.y, 0, y);
    vstore8(corner.z, 0, z);
    vstore8(u0, 0, u);
    vstore8(u1, 0, v);
    vstore8(*s, 0, place_s);
    vstore8(*t, 0, place_t);
    vstore8((float8)(0.0f), 0, angle);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = lanes_lowest(bits);
        const uint kind = as_uint(lights[index[k]].color_kind.w);
        const struct light_shape shape = shapes[kind >> LIGHT_SHAPE_SHIFT];
        float2 place = (float2)(place_s[k], place_t[k]);
        angle[k] = light_near_draw(&place, kind & LIGHT_TYPE_MASK, (float3)(x[k], y[k], z[k]),
                                   shape.edge_u.xyz, shape.edge_v.xyz, u[k], v[k]);
        place_s[k] = place.x;
        place_t[k] = place.y;
    }
    *s = vload8(0, place_s);
    *t = vload8(0, place_t);
    return vload8(0, angle);
}

// Samples a light from each p.
//
//   index   of the lights
//   bits    lanes that count
//   normal  geometric, of the surfaces at p: what comes from below them does not count
//   u0, u1  uniform numbers: the place on the light
static inline struct light_lanes light_lanes_sample(
    __global const struct light *lights, __global const struct light_shape *shapes,
    const uint *index, const uint bits, const struct surface *surface, const struct lanes3 p,
    const struct lanes3 normal, const float8 u0, const float8 u1)
{
    const bool same = lanes_bits(vload8(0, index) == index[0]) == 0xffu; // one light for all
    const struct lanes4 org_range =
        same ? lanes_same(lights[index[0]].org_range) : LANES_OF(lights, index, .org_range);
    const struct lanes4 color_kind =
        same ? lanes_same(lights[index[0]].color_kind) : LANES_OF(lights, index, .color_kind);
    const struct lanes3 color = lanes3_xyz(color_kind);
    const uint8 kind = as_uint8(color_kind.w);
    const int8 type = as_int8(kind & LIGHT_TYPE_MASK);
    const int8 is_surface = type > LIGHT_SPOT;
    struct light_lanes out;

    // Find the points on the lights. Where all are points, there may be no shapes.
    struct lanes4 edge_u = {0.0f, 0.0f, 0.0f, 0.0f};
    struct lanes4 edge_v = {0.0f, 0.0f, 0.0f, 0.0f};
    float8 s = u0;
    float8 t = u1;
    float8 height = (float8)(0.0f); // of p over the sides that emit, m
    float8 angle = (float8)(0.0f);  // of lights that are near
    uint near = 0;                  // bits of those
    struct lanes3 way = lanes3_sub(lanes3_xyz(org_range), p);
    if (lanes_bits(type != LIGHT_POINT) != 0) {
        uint shape[LANES];
        vstore8(kind >> LIGHT_SHAPE_SHIFT, 0, shape);
        edge_u = same ? lanes_same(shapes[shape[0]].edge_u) : LANES_OF(shapes, shape, .edge_u);
        edge_v = same ? lanes_same(shapes[shape[0]].edge_v) : LANES_OF(shapes, shape, .edge_v);
        const struct lanes3 u = lanes3_xyz(edge_u);
        const struct lanes3 v = lanes3_xyz(edge_v);
        const float8 below = lanes3_dot(lanes3_normalize(lanes3_cross(u, v)), way);
        height = (kind & LIGHT_TWO_SIDED) != 0u ? fabs(below) : -below;
        const int8 folds = (type == LIGHT_TRIANGLE) & (u0 + u1 > 1.0f);
        s = folds ? 1.0f - u0 : u0;
        t = folds ? 1.0f - u1 : u1;
        const int8 is_disc = type == LIGHT_DISC;
        if (lanes_bits(is_disc) != 0) {
            float8 cosine, sine;
            lanes_cos_sin_turn(&cosine, &sine, u1);
            s = is_disc ? sqrt(u0) * cosine : s;
            t = is_disc ? sqrt(u0) * sine : t;
        }
        near = bits & lanes_bits(light_lanes_are_near(type, way, u, v) & (height > 0.0f));
        if (near != 0)
            near &= ~lanes_bits(light_lanes_are_below(normal, way, u, v));
        if (near != 0)
            angle = light_lanes_draw_near(&s, &t, lights, shapes, index, near, way, u0, u1);
        const struct lanes3 there = lanes3_muladd(u, s, lanes3_muladd(v, t, way));
        way = lanes3_select(is_surface, there, way);
    }
    const float8 distance2 = lanes3_dot(way, way);
    out.distance = sqrt(distance2);
    out.dir = lanes3_scale(way, 1.0f / out.distance);

    // Weigh points and spots by distance, range and cone.
    const float8 window = light_lanes_window(out.distance, org_range.w) / distance2;
    const float8 cone = MULADD(-lanes3_dot(out.dir, lanes3_xyz(edge_u)), edge_u.w, edge_v.w);
    const float8 cut = min8(max8(cone, (float8)(0.0f)), (float8)(1.0f));
    const float8 weight = type == LIGHT_SPOT ? cut * cut * window : window;

    // Weigh surfaces by their side and their size.
    const int8 is_lit = is_surface & (height > 0.0f);
    const uint8 triangle = as_uint8(edge_v.w);
    struct lanes3 emission = color;
    const uint asked = bits & lanes_bits(is_lit & (type == LIGHT_TRIANGLE));
    if (asked != 0)
        emission = light_lanes_emission(surface, asked, triangle, color, s, t);
    const float8 zero = (float8)(0.0f);
    out.density = is_lit ? distance2 * out.distance / (height * edge_u.w) : zero;
    if (near != 0)
        out.density = angle > 0.0f ? 1.0f / angle : out.density;
    out.is_hittable = is_lit & (triangle != EMITTER_NONE);
    out.radiance = lanes3_select(is_lit, emission, lanes3_scale(color, is_surface ? zero : weight));
    out.radiance = lanes3_select(distance2 > 0.0f, out.radiance, lanes3_make(zero, zero, zero));
    return out;
}

#endif
