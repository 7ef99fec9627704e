/**
 * @file
 * The material stage for eight hits side by side (cl/material.cl), on CPUs. Geometry, emission and
 * what is written are of all lanes; textures, and BSDFs of more than the Lambert term, are looked
 * up lane by lane.
 */
#ifndef LIB_MATERIAL_LANES_H
#define LIB_MATERIAL_LANES_H

#include "lib/bsdf.h"
#include "lib/hit_lanes.h"
#include "lib/light_sampler.h"
#include "lib/material_bsdf.h"
#include "lib/shade_lanes.h"
#include "lib/texture_lanes.h"
#include "lib/texture_use.h"

#if SHADE_LANES

// Where rays have met what. Lanes that hit nothing take part as if they had hit the first
// triangle.
struct material_lanes_hits {
    uint slots[LANES];
    uint missed; // bits of slots whose rays hit nothing
    uint own;    // of those that are shaded here
    uint others; // of the rest
    uint triangle[LANES];
    uint material[LANES];
    uint v0[LANES], v1[LANES], v2[LANES];
    lanes_float t, u, v;
    lanes_uint flags;          // of the materials
    uint textured;             // bits of slots shaded here that have a texture of the base colour
    struct texture_lanes base; // where its texels are
};

// BSDFs, lane by lane.
struct material_lanes_bsdf {
    float diffuse_r[LANES], diffuse_g[LANES], diffuse_b[LANES];
    float f0_r[LANES], f0_g[LANES], f0_b[LANES];
    float f90[LANES], dielectric_f0[LANES];
    float normal_x[LANES], normal_y[LANES], normal_z[LANES];
    uint bits[LANES]; // of path.throughput_bits.w
};

// A lane's texture coordinates.
static inline float4 material_lanes_uv(const struct surface *s, const struct material_lanes_hits *h,
                                       const uint k)
{
    const lanes_float u = h->u;
    const lanes_float v = h->v;
    return surface_blend(s->vertices[h->v0[k]].uv, s->vertices[h->v1[k]].uv,
                         s->vertices[h->v2[k]].uv, ((const float *)&u)[k], ((const float *)&v)[k]);
}

// The texture coordinates of all lanes.
static inline struct lanes4 material_lanes_all_uv(const struct surface *s,
                                                  const struct material_lanes_hits *h)
{
    const struct lanes4 a = LANES_OF(s->vertices, h->v0, .uv);
    const struct lanes4 b = LANES_OF(s->vertices, h->v1, .uv);
    const struct lanes4 c = LANES_OF(s->vertices, h->v2, .uv);
    const lanes_float w = 1.0f - h->u - h->v;
    const struct lanes4 out = {w * a.x + h->u * b.x + h->v * c.x, w * a.y + h->u * b.y + h->v * c.y,
                               w * a.z + h->u * b.z + h->v * c.z,
                               w * a.w + h->u * b.w + h->v * c.w};
    return out;
}

// Lanes whose materials have a texture of this use.
static inline uint material_lanes_textured(const struct surface *s,
                                           const struct material_lanes_hits *h, const uint use)
{
    if (!TEXTURE_IS_USED(use))
        return 0;
    const lanes_uint flags =
        LANES_WORD(lanes_uint, s->materials, h->material, .textures[use].flags);
    return lanes_bits((flags & TEXTURE_PRESENT) != 0u);
}

// Sees what rays have hit, and asks for its texels.
//
//   used  bits of the slots, already in h, that there are
//   hit   t, u, v, and the triangle, as in struct hit
static inline void material_lanes_see(struct material_lanes_hits *h, const uint used,
                                      const struct lanes4 hit, const struct surface *s)
{
    const lanes_uint triangle = lanes_as_uint(hit.w);
    const uint met = used & lanes_bits(triangle != HIT_NONE);
    lanes_store(triangle != HIT_NONE ? triangle : (lanes_uint)(0u), h->triangle);
    const struct lanes4 tri = LANES_OF(((__global const float4 *)s->triangles), h->triangle, );
    lanes_store(lanes_as_uint(tri.x), h->v0);
    lanes_store(lanes_as_uint(tri.y), h->v1);
    lanes_store(lanes_as_uint(tri.z), h->v2);
    lanes_store(lanes_as_uint(tri.w), h->material);
    h->t = hit.x;
    h->u = hit.y;
    h->v = hit.z;
    h->flags = LANES_WORD(lanes_uint, s->materials, h->material, .flags);
    h->missed = used & ~met;
    h->own = met & lanes_bits((h->flags & MATERIAL_EXTRAS) == 0u);
    h->others = met & ~h->own;
    h->textured = h->own & lanes_bits((h->flags & MATERIAL_LAMBERT) != 0u) &
                  material_lanes_textured(s, h, TEXTURE_BASE);
    if (h->textured == 0)
        return;
    texture_lanes_find(&h->base, s->materials, h->material, TEXTURE_BASE, h->textured,
                       material_lanes_all_uv(s, h));
#if PREFETCHES
    texture_lanes_warm(&h->base, h->textured, s->texels);
#endif
}

// The same of the eight from place `first` of the queue on.
static inline void material_lanes_meet(struct material_lanes_hits *h,
                                       __global const uint *restrict order, const uint first,
                                       const uint end, __global const struct hit *hits,
                                       const struct surface *s)
{
    const uint used = shade_lanes_slots(h->slots, order, first, end);
    material_lanes_see(h, used, LANES_OF(((__global const float4 *)hits), h->slots, ), s);
}

// Multiplies the emission of those lanes that have a bit with its texture.
static inline struct lanes3 material_lanes_emission(const struct surface *s,
                                                    const struct material_lanes_hits *h,
                                                    const uint bits, const struct lanes3 emission)
{
    if (bits == 0)
        return emission;
    struct texture_lanes lanes;
    texture_lanes_find(&lanes, s->materials, h->material, TEXTURE_EMISSIVE, bits,
                       material_lanes_all_uv(s, h));
    return lanes3_mul(emission, texture_lanes_fetch(&lanes, bits, s->texels));
}

// Looks up one lane that is more than Lambert.
//
//   out  normals are bent where they have to be
static inline void material_lanes_look_up(struct material_lanes_bsdf *out,
                                          __constant struct settings *settings, const bool last,
                                          const struct surface *s,
                                          const struct material_lanes_hits *h, const uint k,
                                          const float3 geometric, const float3 view)
{
    const float4 uv = material_lanes_uv(s, h, k);
    __global const struct material *material = &s->materials[h->material[k]];
    struct texture_values values;
    values.base = texture_fetch_pool(s->texels, &material->textures[TEXTURE_BASE], uv);
    values.surface = texture_fetch_pool(s->texels, &material->textures[TEXTURE_SURFACE], uv);
    values.specular = texture_fetch_pool(s->texels, &material->textures[TEXTURE_SPECULAR], uv);
    values.specular_color =
        texture_fetch_pool(s->texels, &material->textures[TEXTURE_SPECULAR_COLOR], uv);

    struct bsdf b;
    b.view = view;
    b.geometric = geometric;
    b.normal = (float3)(out->normal_x[k], out->normal_y[k], out->normal_z[k]);
    material_bsdf(&b, material, &values, (float4)(1.0f));
    if (luminance(b.f0) > luminance(b.diffuse))
        b.normal = bsdf_bend_normal(&b);
    const bool bounces = !last || (settings->emitter_count != 0 && !bsdf_is_lambert(&b));
    out->diffuse_r[k] = b.diffuse.x;
    out->diffuse_g[k] = b.diffuse.y;
    out->diffuse_b[k] = b.diffuse.z;
    out->f0_r[k] = b.f0.x;
    out->f0_g[k] = b.f0.y;
    out->f0_b[k] = b.f0.z;
    out->f90[k] = b.f90;
    out->dielectric_f0[k] = b.dielectric_f0;
    out->normal_x[k] = b.normal.x;
    out->normal_y[k] = b.normal.y;
    out->normal_z[k] = b.normal.z;
    out->bits[k] = PATH_SHADED | (bounces ? 0u : PATH_NO_BOUNCE) | bsdf_bits(&b);
}

// Hits that are shaded.
struct material_lanes_shaded {
    struct lanes3 org;               // where rays leave the surfaces
    struct lanes3 geometric, normal; // viewer's side
    struct lanes3 diffuse, f0;
    lanes_float f90, dielectric_f0;
    struct lanes3 throughput, radiance; // of their paths
    lanes_uint bits;                    // of path.throughput_bits.w
};

// Shades those of the eight that are shaded here.
//
//   ray_dir, throughput_bits, radiance_normal  rows of their rays and paths
static inline void material_lanes_shade(
    struct material_lanes_shaded *out, __constant struct settings *settings, const uint bounce,
    const struct material_lanes_hits *h, const struct surface *s,
    __global const uint *triangle_emitters, __global const struct light *lights,
    __global const struct light_shape *shapes, __global const float4 *light_nodes,
    __global const uint *light_parents, __global const uint *light_leaves,
    __global const struct ray *rays, const struct lanes4 ray_dir,
    const struct lanes4 throughput_bits, const struct lanes4 radiance_normal)
{
    const uint *slots = h->slots;
    const uint own = h->own;
    const lanes_uint flags = h->flags;
    const bool measures = settings->quantity == QUANTITY_IRRADIANCE && bounce == 0;
    const bool last = bounce + 1 == settings->depth;

    // Find the points and their normals.
    const struct lanes4 row0 = LANES_OF(s->vertices, h->v0, .pos_normal);
    const struct lanes4 row1 = LANES_OF(s->vertices, h->v1, .pos_normal);
    const struct lanes4 row2 = LANES_OF(s->vertices, h->v2, .pos_normal);
    const struct lanes3 corner = lanes3_xyz(row0);
    const struct lanes3 edge1 = lanes3_sub(lanes3_xyz(row1), corner);
    const struct lanes3 edge2 = lanes3_sub(lanes3_xyz(row2), corner);
    const struct lanes3 p = lanes3_muladd(edge1, h->u, lanes3_muladd(edge2, h->v, corner));
    const struct lanes3 dir = lanes3_xyz(ray_dir);
    struct lanes3 geometric = lanes3_normalize(lanes3_cross(edge1, edge2));
    const lanes_float cosine = lanes3_dot(geometric, dir);
    const lanes_int front = cosine < 0.0f;

    // Add what the surfaces emit towards the paths.
    const lanes_uint path_bits = lanes_as_uint(throughput_bits.w);
    struct lanes3 throughput = lanes3_xyz(throughput_bits);
    struct lanes3 radiance = lanes3_xyz(radiance_normal);
    const struct lanes4 emission_row = LANES_OF(s->materials, h->material, .emission);
    struct lanes3 emission = lanes3_xyz(emission_row);
    const lanes_int shines =
        (front | ((flags & MATERIAL_EMITS_BACK) != 0u)) & (lanes3_max(emission) > 0.0f);
    const uint shining = measures ? 0u : own & lanes_bits(shines);
    if (shining != 0) {
        emission = material_lanes_emission(
            s, h, shining & material_lanes_textured(s, h, TEXTURE_EMISSIVE), emission);
        const uint met_by_light =
            shining & lanes_bits((path_bits & PATH_SPECULAR) == 0u); // may be found by lights
        const struct lanes4 org = LANES_OF(rays, slots, .org);
        const lanes_float weight = hit_lanes_weights(
            settings, triangle_emitters, lights, shapes, light_nodes, light_parents, light_leaves,
            h->triangle, met_by_light, lanes3_xyz(org),
            lanes_oct_unpack(lanes_as_uint(radiance_normal.w)), ray_dir.w, h->t, cosine);
        const lanes_float counts = shines ? weight : (lanes_float)(0.0f);
        radiance = lanes3_add(radiance, lanes3_mul(lanes3_scale(throughput, counts), emission));
    }

    // Turn the normals to the viewer; a shading normal that looks away is of no use.
    const lanes_float side = front ? (lanes_float)(1.0f) : (lanes_float)(-1.0f);
    struct lanes3 normal =
        lanes3_scale(hit_lanes_normal(lanes_as_uint(row0.w), lanes_as_uint(row1.w),
                                      lanes_as_uint(row2.w), h->u, h->v, geometric),
                     side);
    geometric = lanes3_scale(geometric, side);
    normal = lanes3_select(lanes3_dot(normal, dir) < -1e-4f, normal, geometric);

    // Find their BSDFs.
    const struct lanes4 base = LANES_OF(s->materials, h->material, .base);
    const uint lambert = measures ? LANES_ALL : lanes_bits((flags & MATERIAL_LAMBERT) != 0u);
    struct lanes3 diffuse = lanes3_xyz(base);
    struct lanes3 f0 = {0.0f, 0.0f, 0.0f};
    lanes_float f90 = (lanes_float)(0.0f);
    lanes_float dielectric_f0 = (lanes_float)(0.0f);
    lanes_uint bits = (lanes_uint)(PATH_SHADED | (last ? PATH_NO_BOUNCE : 0u));
    if (measures) { // f = 1 / pi, so that pi times what leaves is the irradiance
        diffuse = lanes3_make(1.0f, 1.0f, 1.0f);
        throughput = lanes3_scale(throughput, PI);
    } else if (h->textured != 0) {
        diffuse = lanes3_mul(diffuse, texture_lanes_fetch(&h->base, h->textured, s->texels));
    }
    if (own & ~lambert) {
        struct material_lanes_bsdf b;
        float g[3][LANES], d[3][LANES];
        lanes_store(diffuse.x, b.diffuse_r);
        lanes_store(diffuse.y, b.diffuse_g);
        lanes_store(diffuse.z, b.diffuse_b);
        lanes_store(f0.x, b.f0_r);
        lanes_store(f0.y, b.f0_g);
        lanes_store(f0.z, b.f0_b);
        lanes_store(f90, b.f90);
        lanes_store(dielectric_f0, b.dielectric_f0);
        lanes_store(normal.x, b.normal_x);
        lanes_store(normal.y, b.normal_y);
        lanes_store(normal.z, b.normal_z);
        lanes_store(bits, b.bits);
        lanes_store(geometric.x, g[0]);
        lanes_store(geometric.y, g[1]);
        lanes_store(geometric.z, g[2]);
        lanes_store(dir.x, d[0]);
        lanes_store(dir.y, d[1]);
        lanes_store(dir.z, d[2]);
        for (uint rest = own & ~lambert; rest != 0; rest &= rest - 1) {
            const uint k = bits_lowest(rest);
            material_lanes_look_up(&b, settings, last, s, h, k, (float3)(g[0][k], g[1][k], g[2][k]),
                                   -(float3)(d[0][k], d[1][k], d[2][k]));
        }
        diffuse =
            lanes3_make(lanes_load(b.diffuse_r), lanes_load(b.diffuse_g), lanes_load(b.diffuse_b));
        f0 = lanes3_make(lanes_load(b.f0_r), lanes_load(b.f0_g), lanes_load(b.f0_b));
        f90 = lanes_load(b.f90);
        dielectric_f0 = lanes_load(b.dielectric_f0);
        normal =
            lanes3_make(lanes_load(b.normal_x), lanes_load(b.normal_y), lanes_load(b.normal_z));
        bits = lanes_load(b.bits);
    }

    // Those of paths that only collect emission are not lit.
    out->org = hit_lanes_offset(p, geometric);
    out->geometric = geometric;
    out->normal = normal;
    out->diffuse = diffuse;
    out->f0 = f0;
    out->f90 = f90;
    out->dielectric_f0 = dielectric_f0;
    out->throughput = throughput;
    out->radiance = radiance;
    out->bits = (path_bits & PATH_COLLECT) != 0u ? (lanes_uint)(0u) : bits;
}

// Shades those of the eight that are shaded here and writes them, and ends the paths of those that
// hit nothing.
static inline void material_lanes(__constant struct settings *settings, const uint bounce,
                                  const struct material_lanes_hits *h, const struct surface *s,
                                  __global const uint *triangle_emitters,
                                  __global const struct light *lights,
                                  __global const struct light_shape *shapes,
                                  __global const float4 *light_nodes,
                                  __global const uint *light_parents,
                                  __global const uint *light_leaves, __global struct ray *rays,
                                  __global struct path *paths, __global struct shade *shades)
{
    for (uint missed = h->missed; missed != 0; missed &= missed - 1)
        paths[h->slots[bits_lowest(missed)]].throughput_bits.w = as_float(0u);
    if (h->own == 0)
        return;
    const uint *slots = h->slots;
    const uint own = h->own;
    struct material_lanes_shaded m;
    material_lanes_shade(&m, settings, bounce, h, s, triangle_emitters, lights, shapes, light_nodes,
                         light_parents, light_leaves, rays, LANES_OF(rays, slots, .dir),
                         LANES_OF(paths, slots, .throughput_bits),
                         LANES_OF(paths, slots, .radiance_normal));
    LANES_STORE(rays, slots, .org, own,
                lanes4_make(m.org, lanes_as_float(lanes_oct_pack(m.geometric))));
    LANES_STORE(paths, slots, .throughput_bits, own,
                lanes4_make(m.throughput, lanes_as_float(m.bits)));
    LANES_STORE(paths, slots, .radiance_normal, own,
                lanes4_make(m.radiance, lanes_as_float(lanes_oct_pack(m.normal))));
    struct lanes4 shade;
    shade.x = lanes_pack_shares(m.diffuse.x, m.diffuse.y);
    shade.y = lanes_pack_shares(m.diffuse.z, m.dielectric_f0);
    shade.z = lanes_pack_shares(m.f0.x, m.f0.y);
    shade.w = lanes_pack_shares(m.f0.z, m.f90);
    LANES_STORE(((__global float4 *)shades), slots, , own, shade);
}

#endif

#endif
