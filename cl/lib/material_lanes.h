/**
 * @file
 * The material stage for eight hits side by side (cl/material.cl), on CPUs.
 */
#ifndef LIB_MATERIAL_LANES_H
#define LIB_MATERIAL_LANES_H

#include "lib/bsdf.h"
#include "lib/bsdf_lanes.h"
#include "lib/hit_lanes.h"
#include "lib/light_sampler.h"
#include "lib/material_hit.h"
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
    h->own = met & lanes_bits((h->flags & MATERIAL_APART) == 0u);
    h->others = met & ~h->own;
    h->textured = h->own & material_lanes_textured(s, h, TEXTURE_BASE);
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

// Looks up the textures of this use of those lanes that have a bit; 1, 1, 1, 1 in others, and where
// there is none.
static inline struct lanes4 material_lanes_fetch(const struct surface *s,
                                                 const struct material_lanes_hits *h,
                                                 const uint bits, const uint use)
{
    const lanes_float one = (lanes_float)(1.0f);
    const uint textured = bits & material_lanes_textured(s, h, use);
    if (textured == 0)
        return lanes4_make(lanes3_make(one, one, one), one);
    struct texture_lanes lanes;
    texture_lanes_find(&lanes, s->materials, h->material, use, textured,
                       material_lanes_all_uv(s, h));
    return texture_lanes_fetch(&lanes, textured, s->texels);
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

// Turns the normals of those lanes that have a bit as bsdf_bend_normal() does: few have to be.
static inline struct lanes3 material_lanes_bend(const struct lanes3 normal, uint bits,
                                                const struct lanes3 geometric,
                                                const struct lanes3 dir)
{
    float n[3][LANES], g[3][LANES], d[3][LANES];
    struct lanes3 out = normal;
    lanes_store(normal.x, n[0]);
    lanes_store(normal.y, n[1]);
    lanes_store(normal.z, n[2]);
    lanes_store(geometric.x, g[0]);
    lanes_store(geometric.y, g[1]);
    lanes_store(geometric.z, g[2]);
    lanes_store(dir.x, d[0]);
    lanes_store(dir.y, d[1]);
    lanes_store(dir.z, d[2]);
    for (; bits != 0; bits &= bits - 1) {
        const uint k = bits_lowest(bits);
        struct bsdf b;
        b.normal = (float3)(n[0][k], n[1][k], n[2][k]);
        b.geometric = (float3)(g[0][k], g[1][k], g[2][k]);
        b.view = -(float3)(d[0][k], d[1][k], d[2][k]);
        out = lanes3_put(out, k, bsdf_bend_normal(&b));
    }
    return out;
}

// Finds the BSDFs of those lanes that have a bit, which may be more than Lambert: material_bsdf()
// of lib/material_bsdf.h. The base colour is in out->diffuse, where the diffuse one is left.
//
//   last  no ray follows that is lit
static inline void material_lanes_bsdf(struct material_lanes_shaded *out, const uint own,
                                       __constant struct settings *settings, const bool last,
                                       const struct surface *s, const struct material_lanes_hits *h,
                                       const struct lanes3 dir)
{
    const lanes_float zero = (lanes_float)(0.0f);
    const lanes_float one = (lanes_float)(1.0f);
    const lanes_int mask = lanes_mask(own);
    const struct lanes3 base = out->diffuse;
    const struct lanes4 surface = material_lanes_fetch(s, h, own, TEXTURE_SURFACE);
    const struct lanes4 factor = LANES_OF(s->materials, h->material, .specular);
    const struct lanes3 tint = lanes3_xyz(factor);

    // Metallic-roughness.
    const lanes_float metallic =
        LANES_WORD(lanes_float, s->materials, h->material, .metallic) * surface.z;
    lanes_float roughness =
        LANES_WORD(lanes_float, s->materials, h->material, .roughness) * surface.y;
    const lanes_float strength = factor.w * material_lanes_fetch(s, h, own, TEXTURE_SPECULAR).w;
    const struct lanes3 color =
        lanes3_mul(tint, lanes3_xyz(material_lanes_fetch(s, h, own, TEXTURE_SPECULAR_COLOR)));
    const struct lanes3 dielectric = lanes3_make(lanes_min(0.04f * color.x, one) * strength,
                                                 lanes_min(0.04f * color.y, one) * strength,
                                                 lanes_min(0.04f * color.z, one) * strength);
    struct lanes3 diffuse = lanes3_scale(base, 1.0f - metallic);
    struct lanes3 f0 = lanes3_muladd(lanes3_sub(base, dielectric), metallic, dielectric);
    lanes_float f90 = MULADD(1.0f - strength, metallic, strength);
    lanes_float dielectric_f0 = lanes3_max(dielectric);
    lanes_float dielectric_f90 = strength;

    // Specular-glossiness.
    const lanes_int is_glossiness = (h->flags & MATERIAL_SPECULAR_GLOSSINESS) != 0u;
    if ((own & lanes_bits(is_glossiness)) != 0) {
        const struct lanes3 specular = lanes3_mul(tint, lanes3_xyz(surface));
        const lanes_float most = lanes3_max(specular);
        const lanes_float glossiness =
            LANES_WORD(lanes_float, s->materials, h->material, .glossiness) * surface.w;
        const lanes_float reflects = most > 0.0f ? one : zero;
#if BRDF_PHONG
        const struct lanes3 rest = base;
#else
        const struct lanes3 rest = lanes3_scale(base, 1.0f - most);
#endif
        diffuse = lanes3_select(is_glossiness, rest, diffuse);
        f0 = lanes3_select(is_glossiness, specular, f0);
        f90 = is_glossiness ? reflects : f90;
        dielectric_f0 = is_glossiness ? most : dielectric_f0;
        dielectric_f90 = is_glossiness ? reflects : dielectric_f90;
        roughness = is_glossiness ? 1.0f - glossiness : roughness;
    }

    // bsdf_bits(), with the roughness that bsdf_alpha() makes of this.
#if BRDF_PHONG
    f90 = zero;
    const lanes_uint mirror = roughness <= 0.0f ? (lanes_uint)(PATH_MIRROR) : (lanes_uint)(0u);
    const lanes_float rough = lanes_max(roughness, (lanes_float)(1e-3f));
#else
    const lanes_uint mirror = (lanes_uint)(0u);
    const lanes_float rough =
        sqrt(lanes_max(roughness * roughness, (lanes_float)(MATERIAL_SMOOTH)));
#endif
    lanes_int lobe = (lanes3_max(f0) > 0.0f) | (f90 > 0.0f); // not bsdf_is_lambert()
#if LAYERS
    lobe |= dielectric_f90 > 0.0f;
#endif
    const lanes_int bounces =
        last ? lobe & (lanes_int)(settings->emitter_count != 0 ? -1 : 0) : (lanes_int)(-1);
    const lanes_uint bits =
        PATH_SHADED | (bounces ? (lanes_uint)(0u) : (lanes_uint)(PATH_NO_BOUNCE)) | mirror |
        lanes_as_uint(lanes_to_int(
            MULADD(lanes_min(lanes_max(dielectric_f90, zero), one), zero + 255.0f, zero + 0.5f)))
            << PATH_F90_SHIFT |
        lanes_as_uint(lanes_to_int(MULADD(lanes_min(rough, one), zero + 65535.0f, zero + 0.5f)))
            << PATH_ROUGHNESS_SHIFT;

    // Metals are bent where what they mirror would be below the surface.
    const lanes_float nov = -lanes3_dot(out->normal, dir);
    const lanes_float view_z = -lanes3_dot(out->geometric, dir);
    const lanes_float mirrored_z = // of 2 (N V) N - V
        MULADD(2.0f * nov, lanes3_dot(out->normal, out->geometric), -view_z);
    const lanes_int below = mirrored_z < lanes_min(0.9f * view_z, zero + 0.025f);
    const lanes_int is_metal = lanes_luminance(f0) > lanes_luminance(diffuse);
    const uint bent = own & lanes_bits(below & is_metal);
    if (bent != 0)
        out->normal = material_lanes_bend(out->normal, bent, out->geometric, dir);

    out->diffuse = lanes3_select(mask, diffuse, base);
    out->f0 = lanes3_select(mask, f0, out->f0);
    out->f90 = mask ? f90 : out->f90;
    out->dielectric_f0 = mask ? dielectric_f0 : out->dielectric_f0;
    out->bits = mask ? bits : out->bits;
}

// The vertex colours of all lanes.
static inline struct lanes3 material_lanes_color(const struct surface *s,
                                                 const struct material_lanes_hits *h)
{
    const struct lanes4 a = lanes_unpack_shares(LANES_WORD(lanes_uint, s->colors, h->v0, .x),
                                                LANES_WORD(lanes_uint, s->colors, h->v0, .y));
    const struct lanes4 b = lanes_unpack_shares(LANES_WORD(lanes_uint, s->colors, h->v1, .x),
                                                LANES_WORD(lanes_uint, s->colors, h->v1, .y));
    const struct lanes4 c = lanes_unpack_shares(LANES_WORD(lanes_uint, s->colors, h->v2, .x),
                                                LANES_WORD(lanes_uint, s->colors, h->v2, .y));
    return lanes3_muladd(lanes3_xyz(a), 1.0f - h->u - h->v,
                         lanes3_muladd(lanes3_xyz(b), h->u, lanes3_scale(lanes3_xyz(c), h->v)));
}

#if NORMAL_MAPS

static inline struct lanes3 material_lanes_tangent(const lanes_uint packed)
{
    return lanes_oct_unpack(packed & ~OCT_FLAG);
}

// The shading normals that normal maps make of the interpolated ones in those lanes that have a
// bit: normal_map_apply().
//
//   normal  interpolated, viewer's side
//   side    1 where that is the front, else -1
//   dir     of the rays
static inline struct lanes3 material_lanes_map(const struct surface *s,
                                               __global const uint *tangents,
                                               const struct material_lanes_hits *h, const uint bits,
                                               const struct lanes3 normal, const lanes_float side,
                                               const struct lanes3 dir)
{
    // The frame is that of the front.
    const struct lanes3 ahead = lanes3_scale(normal, side);
    const lanes_uint packed = LANES_WORD(lanes_uint, tangents, h->v0, );
    const struct lanes3 tangent = lanes3_muladd(
        material_lanes_tangent(packed), 1.0f - h->u - h->v,
        lanes3_muladd(
            material_lanes_tangent(LANES_WORD(lanes_uint, tangents, h->v1, )), h->u,
            lanes3_scale(material_lanes_tangent(LANES_WORD(lanes_uint, tangents, h->v2, )), h->v)));
    const struct lanes3 flat = lanes3_muladd(ahead, -lanes3_dot(tangent, ahead), tangent);
    const struct lanes3 t = lanes3_normalize(flat);
    const lanes_float hand = (packed & OCT_FLAG) != 0u ? (lanes_float)(-1.0f) : (lanes_float)(1.0f);
    const struct lanes3 bitangent = lanes3_scale(lanes3_cross(ahead, t), hand);

    const struct lanes4 texel = material_lanes_fetch(s, h, bits, TEXTURE_NORMAL);
    const lanes_float scale = LANES_WORD(lanes_float, s->materials, h->material, .normal_scale);
    const struct lanes3 bent =
        lanes3_muladd(t, (2.0f * texel.x - 1.0f) * scale,
                      lanes3_muladd(bitangent, (2.0f * texel.y - 1.0f) * scale,
                                    lanes3_scale(ahead, 2.0f * texel.z - 1.0f)));
    const struct lanes3 mapped = lanes3_scale(lanes3_normalize(bent), side);
    const lanes_int maps = lanes_mask(bits) & (lanes3_dot(flat, flat) >= 1e-12f) &
                           (lanes3_dot(bent, bent) > 1e-12f) & (lanes3_dot(mapped, dir) < -1e-4f);
    return lanes3_select(maps, mapped, normal);
}

#endif

// Shades those of the eight that are shaded here.
//
//   ray_dir, throughput_bits, radiance_normal  rows of their rays and paths
static inline void material_lanes_shade(
    struct material_lanes_shaded *out, __constant struct settings *settings, const uint bounce,
    const struct material_lanes_hits *h, const struct material_scene *scene,
    __global const struct ray *rays, const struct lanes4 ray_dir,
    const struct lanes4 throughput_bits, const struct lanes4 radiance_normal)
{
    const struct surface *s = &scene->surface;
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
    const uint lit = own & lanes_bits((path_bits & PATH_COLLECT) == 0u); // others only shine
    struct lanes3 throughput = lanes3_xyz(throughput_bits);
    struct lanes3 radiance = lanes3_xyz(radiance_normal);
    const struct lanes4 emission_row = LANES_OF(s->materials, h->material, .emission);
    struct lanes3 emission = lanes3_xyz(emission_row);
    const lanes_int shines =
        (front | ((flags & MATERIAL_EMITS_BACK) != 0u)) & (lanes3_max(emission) > 0.0f);
    const uint shining = measures ? 0u : own & lanes_bits(shines);
    if (shining != 0) {
        emission =
            lanes3_mul(emission, lanes3_xyz(material_lanes_fetch(s, h, shining, TEXTURE_EMISSIVE)));
        const uint met_by_light =
            shining & lanes_bits((path_bits & PATH_SPECULAR) == 0u); // may be found by lights
        const struct lanes4 org = LANES_OF(rays, slots, .org);
        const lanes_float weight = hit_lanes_weights(
            settings, scene->triangle_emitters, scene->lights, scene->shapes, scene->light_nodes,
            scene->light_parents, scene->light_leaves, h->triangle, met_by_light, lanes3_xyz(org),
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
#if NORMAL_MAPS
    const uint mapped = measures ? 0u : lit & lanes_bits((flags & MATERIAL_NORMAL_MAP) != 0u);
    if (mapped != 0)
        normal = material_lanes_map(s, scene->tangents, h, mapped, normal, side, dir);
#endif

    // Find their BSDFs.
    const struct lanes4 base = LANES_OF(s->materials, h->material, .base);
    const uint lambert = measures ? LANES_ALL : lanes_bits((flags & MATERIAL_LAMBERT) != 0u);
    const lanes_float zero = (lanes_float)(0.0f);
    out->org = hit_lanes_offset(p, geometric);
    out->geometric = geometric;
    out->normal = normal;
    out->diffuse = lanes3_xyz(base);
    out->f0 = lanes3_make(zero, zero, zero);
    out->f90 = zero;
    out->dielectric_f0 = zero;
    out->bits = (lanes_uint)(PATH_SHADED | (last ? PATH_NO_BOUNCE : 0u));
    if (measures) { // f = 1 / pi, so that pi times what leaves is the irradiance
        out->diffuse = lanes3_make(zero + 1.0f, zero + 1.0f, zero + 1.0f);
        throughput = lanes3_scale(throughput, PI);
    } else if (h->textured != 0) {
        out->diffuse = lanes3_mul(
            out->diffuse, lanes3_xyz(texture_lanes_fetch(&h->base, h->textured, s->texels)));
    }
    const lanes_int colored = (flags & MATERIAL_VERTEX_COLOR) != 0u;
    if (!measures && (lit & lanes_bits(colored)) != 0)
        out->diffuse =
            lanes3_select(colored & lanes_mask(lit),
                          lanes3_mul(out->diffuse, material_lanes_color(s, h)), out->diffuse);
    if (lit & ~lambert)
        material_lanes_bsdf(out, lit & ~lambert, settings, last, s, h, dir);

    out->throughput = throughput;
    out->radiance = radiance;
    out->bits = lanes_mask(lit) ? out->bits : (lanes_uint)(0u);
}

// Shades those of the eight that are shaded here and writes them, and ends the paths of those that
// hit nothing.
static inline void material_lanes(__constant struct settings *settings, const uint bounce,
                                  const struct material_lanes_hits *h,
                                  const struct material_scene *scene, __global struct ray *rays,
                                  __global struct path *paths, __global struct shade *shades)
{
    for (uint missed = h->missed; missed != 0; missed &= missed - 1)
        paths[h->slots[bits_lowest(missed)]].throughput_bits.w = as_float(0u);
    if (h->own == 0)
        return;
    const uint *slots = h->slots;
    const uint own = h->own;
    struct material_lanes_shaded m;
    material_lanes_shade(&m, settings, bounce, h, scene, rays, LANES_OF(rays, slots, .dir),
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
