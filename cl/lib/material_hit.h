/**
 * @file
 * One hit: adds what the surface emits, fetches colours, and writes the hit for the stages that
 * light it and go on from it. For cl/material.cl, and for cl/bounce.cl, which traces and lights it
 * as well.
 */
#ifndef LIB_MATERIAL_HIT_H
#define LIB_MATERIAL_HIT_H

#include "lib/bsdf.h"
#include "lib/layers.h"
#include "lib/light_sampler.h"
#include "lib/material_bsdf.h"
#include "lib/normal_map.h"
#include "lib/samples.h"
#include "lib/texture_use.h"
#include "shared/ray.h"

#ifndef EMITTERS
#define EMITTERS 1 // some triangle is one
#endif

// What hits are shaded by.
struct material_scene {
    struct surface surface;
    __global const uint *triangle_emitters;
    __global const struct light *lights;
    __global const struct light_shape *shapes;
    __global const float4 *light_nodes; // of the light sampler's own hierarchy
    __global const uint *light_parents, *light_leaves;
    __global const uint4 *points; // of samples
    __global const uint *places;
#if NORMAL_MAPS
    __global const uint *tangents;
#endif
};

// Makes the BSDF of the first hit that measures irradiance: f = 1 / pi, so that pi times what
// leaves is E.
static inline void material_measure_irradiance(struct bsdf *b)
{
    b->diffuse = (float3)(1.0f);
    b->f0 = (float3)(0.0f);
    b->f90 = 0.0f;
    b->dielectric_f0 = 0.0f;
    b->dielectric_f90 = 0.0f;
    b->alpha = 1.0f;
    b->mirror = false;
}

#if LAYERS
// A uniform number of the path's own, for choosing a layer.
static inline float material_number(__constant struct settings *settings,
                                    __global const uint4 *restrict points,
                                    __global const uint *restrict places, const struct batch batch,
                                    const uint slot, const uint bounce)
{
    const struct path_place place = samples_place(batch, places, slot);
    return rng_unit(
        samples_draw(settings, points, place.pixel, place.sample, bounce, RNG_USE_LAYER, 0).x);
}
#endif

#if !TEXTURE_IMAGES

// Fetches what the textures say from the pool.
static inline void material_fetch(struct texture_values *out, __global const uint *texels,
                                  __global const struct material *material, const float4 uv)
{
    out->base = texture_fetch_use(texels, material, TEXTURE_BASE, uv);
    out->surface = texture_fetch_use(texels, material, TEXTURE_SURFACE, uv);
    out->emissive = texture_fetch_use(texels, material, TEXTURE_EMISSIVE, uv);
    out->specular = texture_fetch_use(texels, material, TEXTURE_SPECULAR, uv);
    out->specular_color = texture_fetch_use(texels, material, TEXTURE_SPECULAR_COLOR, uv);
#if NORMAL_MAPS
    out->normal = texture_fetch_use(texels, material, TEXTURE_NORMAL, uv);
#endif
#if LAYERS
    layer_fetch(out, texels, material, uv);
#endif
}

#endif

// Texture coordinates of a hit.
static inline float4 material_uv(const struct surface *surface, const struct triangle tri,
                                 const struct hit hit)
{
    return surface_blend(surface->vertices[tri.v0].uv, surface->vertices[tri.v1].uv,
                         surface->vertices[tri.v2].uv, hit.u, hit.v);
}

#if EMITTERS
// What a bounce's find of a surface that emits counts for, where light samples could have found it.
//
//   before  place of the path's last shaded hit
//   cosine  between ray and the surface's normal
static inline float material_emission_weight(__constant struct settings *settings,
                                             const struct material_scene *scene,
                                             const struct hit hit, const uint emitter,
                                             const struct ray ray, const uint normal_before,
                                             const float cosine)
{
    const float3 org = ray.org.xyz;
    const float density =
        light_hit_density(scene->lights, scene->shapes, emitter, org, hit.t, cosine);
    const float3 before = normalize(oct_unpack(normal_before).xyz);
    const float count = light_expected_count(settings, scene->light_nodes, scene->light_parents,
                                             scene->light_leaves, org, before, emitter);
    return mis_weight(ray.dir.w, count * density);
}
#endif

// Shades the hit of a slot. Returns whether there is a surface to light.
static inline bool material_hit(__constant struct settings *settings, const struct batch batch,
                                const uint bounce, const struct material_scene *scene,
                                const uint slot, const struct hit hit,
                                const struct texture_values *values, __global struct ray *rays,
                                __global struct path *paths, __global struct shade *shades)
{
    const struct surface *surface = &scene->surface;
    const struct triangle tri = surface->triangles[hit.triangle];
    __global const struct material *material = &surface->materials[tri.material];
    const uint flags = material->flags;
    const float3 dir = rays[slot].dir.xyz;
    float3 throughput = paths[slot].throughput_bits.xyz;
    float3 radiance = paths[slot].radiance_normal.xyz;
    const uint path_flags = as_uint(paths[slot].throughput_bits.w);
    const bool measures = settings->quantity == QUANTITY_IRRADIANCE && bounce == 0;

    // Find the point, and its normals.
    const float4 row0 = surface->vertices[tri.v0].pos_normal;
    const float4 row1 = surface->vertices[tri.v1].pos_normal;
    const float4 row2 = surface->vertices[tri.v2].pos_normal;
    const float3 edge1 = row1.xyz - row0.xyz;
    const float3 edge2 = row2.xyz - row0.xyz;
    const float3 p = row0.xyz + hit.u * edge1 + hit.v * edge2;
    float3 geometric = normalize(cross(edge1, edge2));
    const bool front = dot(geometric, dir) < 0.0f;

    float4 color = (float4)(1.0f);
    if (flags & MATERIAL_VERTEX_COLOR)
        color = surface_color(surface, tri, hit.u, hit.v);

    // Add what the surface emits towards the path.
    const float3 emission = material->emission.xyz * values->emissive.xyz;
    if (!measures && (front || (flags & MATERIAL_EMITS_BACK)) && max3(emission) > 0.0f) {
        float weight = 1.0f;
#if EMITTERS
        const uint emitter = scene->triangle_emitters[hit.triangle];
        if (!(path_flags & PATH_SPECULAR) && emitter != EMITTER_NONE)
            weight = material_emission_weight(settings, scene, hit, emitter, rays[slot],
                                              as_uint(paths[slot].radiance_normal.w),
                                              fabs(dot(geometric, dir)));
#endif
        radiance += throughput * emission * weight;
    }

    // An unlit surface shows its colour and ends the path.
    const bool unlit = (flags & MATERIAL_UNLIT) && !measures;
    if (unlit && !(path_flags & PATH_COLLECT))
        radiance += throughput * material->base.xyz * values->base.xyz * color.xyz;
    if (unlit || (path_flags & PATH_COLLECT)) {
        paths[slot].throughput_bits.w = as_float(0u);
        paths[slot].radiance_normal.xyz = radiance;
        return false;
    }

    // Turn the normals to the viewer; a shading normal that looks away is of no use.
    struct bsdf b;
    b.view = -dir;
    const float3 blended = (1.0f - hit.u - hit.v) * normalize(oct_unpack(as_uint(row0.w)).xyz) +
                           hit.u * normalize(oct_unpack(as_uint(row1.w)).xyz) +
                           hit.v * normalize(oct_unpack(as_uint(row2.w)).xyz);
    float3 normal = dot(blended, blended) > 0.0f ? normalize(blended) : geometric;
    normal = dot(normal, geometric) < 0.0f ? -normal : normal;
    geometric = front ? geometric : -geometric;
    normal = front ? normal : -normal;
    b.geometric = geometric;
    b.normal = dot(normal, b.view) > 1e-4f ? normal : geometric;
#if LAYERS
    const float3 smooth_normal = b.normal;
    float3 coat_normal = smooth_normal;
#if NORMAL_MAPS
    if (flags & MATERIAL_COAT_NORMAL_MAP)
        coat_normal = normal_map_apply(&b, material->coat_normal_scale, values->coat_normal.xyz,
                                       front, scene->tangents, tri, hit.u, hit.v);
#endif
#endif
#if NORMAL_MAPS
    if ((flags & MATERIAL_NORMAL_MAP) && !measures)
        b.normal = normal_map_apply(&b, material->normal_scale, values->normal.xyz, front,
                                    scene->tangents, tri, hit.u, hit.v);
#endif

    material_bsdf(&b, material, values, color);
    if (!measures && luminance(b.f0) > luminance(b.diffuse))
        b.normal = bsdf_bend_normal(&b);
    if (measures) {
        material_measure_irradiance(&b);
        throughput *= PI;
    }
#if LAYERS
    else if (flags & MATERIAL_LAYERED)
        throughput *= layer_choose(
            &b, material, values, color, smooth_normal, coat_normal,
            material_number(settings, scene->points, scene->places, batch, slot, bounce));
#endif

    // Past the last shaded hit a ray goes on only to collect emission that light samples cannot
    // find as well.
    const bool last = bounce + 1 == settings->depth;
    const bool bounces = !last || (settings->emitter_count != 0 && !bsdf_is_lambert(&b));
    bsdf_store(&rays[slot], &paths[slot], &shades[slot], &b, surface_offset(p, b.geometric),
               throughput, radiance, PATH_SHADED | (bounces ? 0u : PATH_NO_BOUNCE));
    return true;
}

#endif
