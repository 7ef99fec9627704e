/**
 * @file
 * Triangles and rectangles near a point, sampled by the solid angle that they take there.
 *
 * Where a light is near, as where a wall meets another that emits, cos / d^2 of the places on it
 * differs without bound, and samples spread evenly over its area have no finite variance. Spread
 * evenly over its solid angle they all bring about the same. Far away both do the same, and area
 * costs less: light_near_make() decides, by the point and the light alone, so that what weighs a
 * ray that hits a light decides alike.
 *
 * Sources: J. Arvo, "Stratified Sampling of Spherical Triangles", SIGGRAPH 1995; the solid angle by
 * A. Van Oosterom, J. Strackee, "The Solid Angle of a Plane Triangle", 1983. Differs from Arvo: the
 * part of the triangle that has a share of its area is found without its angles, as C. Peters,
 * "BRDF Importance Sampling for Polygonal Lights", 2021, does. With a T for the tangent of half the
 * area wanted, the corner x of the triangle (v0, v1, x) solves
 *
 *   x . (v0 x v1 - T (v0 + v1)) = T (1 + v0 . v1)
 *
 * as -v0 does, so x is the other of two points where a line meets the great circle of v0 and v2.
 * Sums of unit vectors stand for 1 + their cosine, so that nothing cancels where an edge passes
 * close to the point.
 */
#ifndef LIB_LIGHT_NEAR_H
#define LIB_LIGHT_NEAR_H

#include "lib/math.h"
#include "shared/light.h"

#define LIGHT_NEAR_SPHERES 4.0f  // squared distance, in squared radii of a sphere about the light
#define LIGHT_NEAR_LEAST   1e-4f // sr: what takes less is a sliver, and sampled by area

// A triangle as seen from a point, on the unit sphere about it.
struct light_view {
    float3 v0, v1, v2; // its corners, unit
    float volume;      // |v0 . (v1 x v2)|
    float apart;       // 1 + v0 . v1
    float along;       // v2 . (v0 + v1)
    float angle;       // its solid angle, sr
};

// Half the squared length: of the sum of two unit vectors it is 1 + their cosine.
static inline float light_view_half(const float3 v)
{
    return 0.5f * dot(v, v);
}

// Sees the triangle that has a corner, from the point, and two edges.
static inline struct light_view light_view_make(const float3 corner, const float3 edge_u,
                                                const float3 edge_v)
{
    const float3 end_u = corner + edge_u;
    const float3 end_v = corner + edge_v;
    const float least = 1e-30f; // m
    const float length0 = max2(length(corner), least);
    const float length1 = max2(length(end_u), least);
    const float length2 = max2(length(end_v), least);
    struct light_view out;
    out.v0 = corner / length0;
    out.v1 = end_u / length1;
    out.v2 = end_v / length2;
    const float3 sum = out.v0 + out.v1;
    out.volume = fabs(dot(corner / length0, cross(edge_u / length1, edge_v / length2)));
    out.apart = light_view_half(sum);
    out.along = dot(out.v2, sum);
    out.angle = 2.0f * atan2(out.volume, out.apart + out.along);
    return out;
}

// Draws a direction, not quite of unit length.
//
//   angle  0 .. its solid angle: of the part of the triangle on the side of v0
//   u1     uniform number
static inline float3 light_view_draw(const struct light_view *view, const float angle,
                                     const float u1)
{
    // Cut that part off by an edge from v1 to a new corner between v0 and v2.
    const float2 half_angle = cos_sin_turn(angle * (0.25f * INV_PI));
    const float3 middle = view->v0 * (view->volume * half_angle.x - view->along * half_angle.y) +
                          view->v2 * (view->apart * half_angle.y);
    const float middle2 = dot(middle, middle);
    const float3 corner =
        middle2 > 0.0f ? middle * (2.0f * dot(middle, view->v0) / middle2) - view->v0 : view->v0;

    // Go along the new edge, evenly in the cosine to v1.
    const float most = light_view_half(view->v1 - corner); // 1 - the cosine at its end
    const float rest = max2(light_view_half(view->v1 + corner), 1e-14f);
    const float share = sqrt(u1 * (rest + (1.0f - u1) * most) / rest);
    return share * corner + (1.0f - u1 * most - share * (1.0f - most)) * view->v1;
}

// A light as seen from a point: a triangle, or the two halves of a rectangle. The second half goes
// on where the first ends, about the same v1, so that near numbers draw near places.
struct light_near {
    struct light_view first, second;
    float angle; // its solid angle, sr; 0 where it is not near, and sampled by area
};

// Sees a light.
//
//   corner  of it, from the point
static inline struct light_near light_near_make(const uint type, const float3 corner,
                                                const float3 edge_u, const float3 edge_v)
{
    struct light_near out;
    out.angle = 0.0f;
    if (type != LIGHT_TRIANGLE && type != LIGHT_RECTANGLE)
        return out;
    const float3 middle = corner + 0.5f * (edge_u + edge_v);
    const float radius2 = 0.25f * (dot(edge_u, edge_u) + dot(edge_v, edge_v));
    if (!(dot(middle, middle) < LIGHT_NEAR_SPHERES * radius2))
        return out;

    out.first = light_view_make(corner, edge_u, edge_v);
    float angle = out.first.angle;
    if (type == LIGHT_RECTANGLE) {
        out.second = light_view_make(corner + edge_v, edge_u - edge_v, edge_u);
        angle += out.second.angle;
    }
    out.angle = angle > LIGHT_NEAR_LEAST ? angle : 0.0f;
    return out;
}

// Whether no part of a light, or of what makes it a parallelogram, is above a surface at the point:
// then no light comes from it, and no place on it is worth much thought.
//
//   normal  of the surface
static inline bool light_is_below(const float3 normal, const float3 corner, const float3 edge_u,
                                  const float3 edge_v)
{
    return dot(normal, corner) + max2(dot(normal, edge_u), 0.0f) + max2(dot(normal, edge_v), 0.0f) <
           0.0f;
}

// Draws a place on a light that is near, evenly in solid angle. Returns that angle; where the light
// is not near it is 0, and there is no place.
//
//   place   out: along the light's edges
//   corner  of the light, from the point
//   u0, u1  uniform numbers
static inline float light_near_draw(float2 *place, const uint type, const float3 corner,
                                    const float3 edge_u, const float3 edge_v, const float u0,
                                    const float u1)
{
    const struct light_near near = light_near_make(type, corner, edge_u, edge_v);
    if (!(near.angle > 0.0f))
        return 0.0f;
    const float part = u0 * near.angle;
    const bool is_second = part >= near.first.angle && type == LIGHT_RECTANGLE;
    const struct light_view view = is_second ? near.second : near.first;
    const float3 dir = light_view_draw(&view, is_second ? part - near.first.angle : part, u1);

    // See where the direction meets the light's plane. What rounding puts beside the light is moved
    // to its edge.
    const float3 normal = cross(edge_u, edge_v);
    const float3 from = dir * (dot(normal, corner) / dot(normal, dir)) - corner;
    const float scale = 1.0f / dot(normal, normal);
    const float s = min2(max2(dot(from, cross(edge_v, normal)) * scale, 0.0f), 1.0f);
    const float most = type == LIGHT_RECTANGLE ? 1.0f : 1.0f - s;
    const float t = min2(max2(dot(from, cross(normal, edge_u)) * scale, 0.0f), most);
    *place = (float2)(s, t);
    return near.angle;
}

#endif
