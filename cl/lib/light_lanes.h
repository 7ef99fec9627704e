/**
 * @file
 * light_sample() of lib/light.h for paths side by side.
 */
#ifndef LIB_LIGHT_LANES_H
#define LIB_LIGHT_LANES_H

#include "lib/lanes.h"
#include "lib/light.h"

// struct light_sample, lane by lane.
struct light_lanes {
    struct lanes3 dir, radiance;
    lanes_float distance, density;
    lanes_int is_hittable;
};

// What triangles of `bits` emit, where their materials have to be asked.
static inline struct lanes3 light_lanes_emission(const struct surface *surface, uint bits,
                                                 const lanes_uint triangle,
                                                 const struct lanes3 color, const lanes_float s,
                                                 const lanes_float t)
{
    uint triangles[LANES];
    float u[LANES], v[LANES], r[LANES], g[LANES], b[LANES];
    struct lanes3 out = color;
    lanes_store(triangle, triangles);
    lanes_store(s, u);
    lanes_store(t, v);
    lanes_store(color.x, r);
    lanes_store(color.y, g);
    lanes_store(color.z, b);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        const float3 emission =
            light_triangle_emission(surface, triangles[k], (float3)(r[k], g[k], b[k]), u[k], v[k]);
        out = lanes3_put(out, k, emission);
    }
    return out;
}

// The glTF window that ends lights at their ranges: light_window().
static inline lanes_float light_lanes_window(const lanes_float distance, const lanes_float range)
{
    const lanes_float x = distance / range;
    const lanes_float window = lanes_max(1.0f - x * x * x * x, (lanes_float)(0.0f));
    return range == LIGHT_NO_RANGE ? (lanes_float)(1.0f) : window;
}

// Which lights are near enough for light_near_make() to look at them, with the same rule.
static inline lanes_int light_lanes_are_near(const lanes_int type, const struct lanes3 corner,
                                             const struct lanes3 edge_u, const struct lanes3 edge_v)
{
    const struct lanes3 diagonal = lanes3_add(edge_u, edge_v);
    const struct lanes3 middle = lanes3_muladd(diagonal, (lanes_float)(0.5f), corner);
    const lanes_float radius2 = 0.25f * (lanes3_dot(edge_u, edge_u) + lanes3_dot(edge_v, edge_v));
    return ((type == LIGHT_TRIANGLE) | (type == LIGHT_RECTANGLE)) &
           (lanes3_dot(middle, middle) < LIGHT_NEAR_SPHERES * radius2);
}

// light_is_below()
static inline lanes_int light_lanes_are_below(const struct lanes3 normal,
                                              const struct lanes3 corner,
                                              const struct lanes3 edge_u,
                                              const struct lanes3 edge_v)
{
    const lanes_float zero = (lanes_float)(0.0f);
    return lanes3_dot(normal, corner) + lanes_max(lanes3_dot(normal, edge_u), zero) +
               lanes_max(lanes3_dot(normal, edge_v), zero) <
           0.0f;
}

// light_near_draw() of those lanes that have a bit. Returns the lights' solid angles, 0 of others.
//
//   s, t    in, out: places along the lights' edges
//   corner  of the lights, from the points
static inline lanes_float light_lanes_draw_near(lanes_float *s, lanes_float *t,
                                                __global const struct light *lights,
                                                __global const struct light_shape *shapes,
                                                const uint *index, uint bits,
                                                const struct lanes3 corner, const lanes_float u0,
                                                const lanes_float u1)
{
    float x[LANES], y[LANES], z[LANES], u[LANES], v[LANES];
    float place_s[LANES], place_t[LANES], angle[LANES];
    lanes_store(corner.x, x);
    lanes_store(corner.y, y);
    lanes_store(corner.z, z);
    lanes_store(u0, u);
    lanes_store(u1, v);
    lanes_store(*s, place_s);
    lanes_store(*t, place_t);
    lanes_store((lanes_float)(0.0f), angle);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        const uint kind = as_uint(lights[index[k]].color_kind.w);
        const struct light_shape shape = shapes[kind >> LIGHT_SHAPE_SHIFT];
        float2 place = (float2)(place_s[k], place_t[k]);
        angle[k] = light_near_draw(&place, kind & LIGHT_TYPE_MASK, (float3)(x[k], y[k], z[k]),
                                   shape.edge_u.xyz, shape.edge_v.xyz, u[k], v[k]);
        place_s[k] = place.x;
        place_t[k] = place.y;
    }
    *s = lanes_load(place_s);
    *t = lanes_load(place_t);
    return lanes_load(angle);
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
    const struct lanes3 normal, const lanes_float u0, const lanes_float u1)
{
    const bool same = lanes_bits(lanes_load(index) == index[0]) == LANES_ALL; // one light for all
    struct lanes4 org_range, color_kind;
    if (same) {
        org_range = lanes_same(lights[index[0]].org_range);
        color_kind = lanes_same(lights[index[0]].color_kind);
    } else {
        uint apart[LANES];
        lanes_store(lanes_from_here(lanes_load(index)), apart);
        org_range = LANES_OF(lights, apart, .org_range);
        color_kind = LANES_OF(lights, apart, .color_kind);
    }
    const struct lanes3 color = lanes3_xyz(color_kind);
    const lanes_uint kind = lanes_as_uint(color_kind.w);
    const lanes_int type = lanes_as_int(kind & LIGHT_TYPE_MASK);
    const lanes_int is_surface = type > LIGHT_SPOT;
    struct light_lanes out;

    // Find the points on the lights. Where all are points, there may be no shapes.
    struct lanes4 edge_u = {0.0f, 0.0f, 0.0f, 0.0f};
    struct lanes4 edge_v = {0.0f, 0.0f, 0.0f, 0.0f};
    lanes_float s = u0;
    lanes_float t = u1;
    lanes_float height = (lanes_float)(0.0f); // of p over the sides that emit, times |u x v|
    lanes_float angle = (lanes_float)(0.0f);  // of lights that are near
    uint near = 0;                            // bits of those
    struct lanes3 way = lanes3_sub(lanes3_xyz(org_range), p);
    if (lanes_bits(type != LIGHT_POINT) != 0) {
        if (same) {
            const uint shape = as_uint(lights[index[0]].color_kind.w) >> LIGHT_SHAPE_SHIFT;
            edge_u = lanes_same(shapes[shape].edge_u);
            edge_v = lanes_same(shapes[shape].edge_v);
        } else {
            uint apart[LANES];
            lanes_store(lanes_from_here(kind >> LIGHT_SHAPE_SHIFT), apart);
            edge_u = LANES_OF(shapes, apart, .edge_u);
            edge_v = LANES_OF(shapes, apart, .edge_v);
        }
        const struct lanes3 u = lanes3_xyz(edge_u);
        const struct lanes3 v = lanes3_xyz(edge_v);
        const lanes_float below = lanes3_dot(lanes3_cross(u, v), way);
        height = (kind & LIGHT_TWO_SIDED) != 0u ? fabs(below) : -below;
        const lanes_int folds = (type == LIGHT_TRIANGLE) & (u0 + u1 > 1.0f);
        s = folds ? 1.0f - u0 : u0;
        t = folds ? 1.0f - u1 : u1;
        const lanes_int is_disc = type == LIGHT_DISC;
        if (lanes_bits(is_disc) != 0) {
            lanes_float cosine, sine;
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
    const lanes_float distance2 = lanes3_dot(way, way);
    const lanes_float per_distance = lanes_rsqrt(distance2);
    out.distance = distance2 * per_distance;
    out.dir = lanes3_scale(way, per_distance);

    // Weigh points and spots by distance, range and cone.
    const lanes_float zero = (lanes_float)(0.0f);
    lanes_float weight = zero;
    if (lanes_bits(is_surface) != LANES_ALL) {
        const lanes_float window = light_lanes_window(out.distance, org_range.w) / distance2;
        const lanes_float cone =
            MULADD(-lanes3_dot(out.dir, lanes3_xyz(edge_u)), edge_u.w, edge_v.w);
        const lanes_float cut = lanes_min(lanes_max(cone, zero), (lanes_float)(1.0f));
        weight = type == LIGHT_SPOT ? cut * cut * window : window;
        weight = is_surface ? zero : weight;
    }

    // Weigh surfaces by their side and their size.
    const lanes_int is_lit = is_surface & (height > 0.0f);
    const lanes_uint triangle = lanes_as_uint(edge_v.w);
    struct lanes3 emission = color;
    const uint asked = bits & lanes_bits(is_lit & (type == LIGHT_TRIANGLE));
    if (asked != 0)
        emission = light_lanes_emission(surface, asked, triangle, color, s, t);
    const lanes_float size = type == LIGHT_TRIANGLE ? (lanes_float)(0.5f) // area over |u x v|
                             : type == LIGHT_DISC   ? (lanes_float)(PI)
                                                    : (lanes_float)(1.0f);
    out.density = is_lit ? distance2 * out.distance / (height * size) : zero;
    if (near != 0)
        out.density = angle > 0.0f ? 1.0f / angle : out.density;
    out.is_hittable = is_lit & (triangle != EMITTER_NONE);
    out.radiance = lanes3_select(is_lit, emission, lanes3_scale(color, weight));
    out.radiance = lanes3_select(distance2 > 0.0f, out.radiance, lanes3_make(zero, zero, zero));
    return out;
}

#endif
