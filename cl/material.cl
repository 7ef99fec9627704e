// Stage 4, material: what was hit. Adds emission, fetches colours, and writes the hit for the
// stages that light it and go on from it.
//
//   in    hits, paths, rays; with TEXTURES_BOUND: order and ranges of sort, one launch a material
//   out   shades, in place of hits; paths, rays
//   next  direct
//
// Variants: TEXTURES_BOUND takes the hits of one material and its textures as images (thesis
// section 3.3), else all hits of the queue at once, with texels from the pool; NORMAL_MAPS; LAYERS
// (lib/layers.h), with SHEEN_LOBE; BRDF_PHONG; LIGHT_SAMPLER; EMITTERS; UNTEXTURED;
// LIGHT_BVH_FLAT. With SHADE_LANES and the pool most hits are shaded by eights
// (lib/material_lanes.h).

#if TEXTURES_BOUND
#define TEXTURE_IMAGES 1
#endif

#include "lib/material_hit.h"
#include "lib/prefetch.h"
#include "lib/shade_lanes.h"

// Textures that are bound are those of one material; the pool has all, as eight hits side by side
// need.
#if SHADE_LANES && !TEXTURES_BOUND
#define MATERIAL_LANES 1
#include "lib/material_lanes.h"
#else
#define MATERIAL_LANES 0
#endif

#ifndef WG_MATERIAL
#define WG_MATERIAL (MATERIAL_LANES ? 1 : 64) // work items in a group
#endif

#if PREFETCHES && MATERIAL_LANES

#define WARM_VERTICES  16u   // hits ahead of the one that is shaded; each step finds in the cache
#define WARM_TRIANGLES 24u   // what the one before has asked for, the last one texels
#define WARM_LEAST     4096u // triangles of a scene that does not stay in the cache by itself

// Asks for what later hits of the queue will read: of Sponza's bounces it saves a third of this
// kernel's time. Where another thread has shaded them, their places hold no triangles any more, and
// what is asked for is of no use.
static inline void material_warm(const uint i, const uint end, const uint triangle_count,
                                 __global const uint *order, __global const struct hit *hits,
                                 __global const struct triangle *triangles,
                                 __global const struct vertex *vertices)
{
    if (i + WARM_TRIANGLES >= end)
        return;
    const uint far = hits[order[i + WARM_TRIANGLES]].triangle;
    if (far < triangle_count)
        PREFETCH(&triangles[far]);

    const uint middle = hits[order[i + WARM_VERTICES]].triangle;
    if (middle < triangle_count) {
        const struct triangle tri = triangles[middle];
        PREFETCH(&vertices[tri.v0]);
        PREFETCH(&vertices[tri.v1]);
        PREFETCH(&vertices[tri.v2]);
    }
}

#endif

__kernel __attribute__((reqd_work_group_size(WG_MATERIAL, 1, 1))) void material(
    __constant struct settings *settings, const struct batch batch, const uint bounce,
    __global const struct counters *counters, __global const uint *restrict order,
    __global const struct hit *hits, __global const struct vertex *restrict vertices,
    __global const uint2 *restrict colors, __global const struct triangle *restrict triangles,
    __global const struct material *restrict materials,
    __global const uint *restrict triangle_emitters, __global const struct light *restrict lights,
    __global const struct light_shape *restrict shapes, __global const float4 *restrict light_nodes,
    __global const uint *restrict light_parents, __global const uint *restrict light_leaves,
    __global struct ray *restrict rays, __global struct path *restrict paths,
    __global struct shade *shades, __global const uint4 *restrict points,
    __global const uint *restrict places,
#if NORMAL_MAPS
    __global const uint *restrict tangents,
#endif
#if TEXTURES_BOUND
    const uint material_index, __global const uint *restrict ranges,
    __read_only image2d_t base_image, __read_only image2d_t surface_image,
    __read_only image2d_t emissive_image, __read_only image2d_t specular_image,
    __read_only image2d_t specular_color_image
#if NORMAL_MAPS
    ,
    __read_only image2d_t normal_image
#endif
#if LAYERS
    ,
    __read_only image2d_t transmission_image, __read_only image2d_t diffuse_transmission_image,
    __read_only image2d_t diffuse_transmission_color_image, __read_only image2d_t coat_image,
    __read_only image2d_t coat_roughness_image
#if NORMAL_MAPS
    ,
    __read_only image2d_t coat_normal_image
#endif
#endif
#if SHEEN_LOBE
    ,
    __read_only image2d_t sheen_color_image, __read_only image2d_t sheen_roughness_image
#endif
#else
    __global const uint *restrict texels
#endif
)
{
#if TEXTURES_BOUND
    const uint first = ranges[material_index];
    const uint end = ranges[material_index + 1];
#else
#if !MATERIAL_LANES
    const uint first = 0;
#endif
    const uint end = counters[bounce].active;
#endif
    const struct material_scene scene = {
        {vertices, colors, triangles, materials,
#if TEXTURES_BOUND
         0
#else
         texels
#endif
        },
        triangle_emitters,
        lights,
        shapes,
        light_nodes,
        light_parents,
        light_leaves,
        points,
        places,
#if NORMAL_MAPS
        tangents
#endif
    };
#if MATERIAL_LANES
    struct material_lanes_hits eights[2]; // in turns: what the one that is shaded has hit, and the
                                          // next one
    SHADE_LANES_LOOP(place, end)
    {
        const struct material_lanes_hits *eight = &eights[(place / LANES) & 1u];
        if (place % SHADE_RUN == 0)
            material_lanes_meet(&eights[(place / LANES) & 1u], order, place, end, hits,
                                &scene.surface);
#if PREFETCHES
        if (settings->triangle_count > WARM_LEAST)
            for (uint i = place; i < place + LANES; i++)
                material_warm(i, end, settings->triangle_count, order, hits, triangles, vertices);
#endif
        if ((place + LANES) % SHADE_RUN != 0 && place + LANES < end)
            material_lanes_meet(&eights[(place / LANES + 1) & 1u], order, place + LANES, end, hits,
                                &scene.surface);
        material_lanes(settings, bounce, eight, &scene, rays, paths, shades);
        for (uint rest = eight->others; rest != 0; rest &= rest - 1)
#else
    for (uint i = first + get_global_id(0); i < end; i += get_global_size(0))
#endif
        {
#if MATERIAL_LANES
            const uint slot = eight->slots[bits_lowest(rest)];
#else
        const uint slot = order[i];
#endif
            const struct hit hit = hits[slot];
            if (hit.triangle == HIT_NONE) {
                paths[slot].throughput_bits.w = as_float(0u);
                continue;
            }
            const struct triangle tri = triangles[hit.triangle];
            __global const struct material *material = &materials[tri.material];
            const float4 uv = material_uv(&scene.surface, tri, hit);

            // Fetch the colours.
            struct texture_values values;
#if TEXTURES_BOUND
            values.base = texture_fetch_use(base_image, material, TEXTURE_BASE, uv);
            values.surface = texture_fetch_use(surface_image, material, TEXTURE_SURFACE, uv);
            values.emissive = texture_fetch_use(emissive_image, material, TEXTURE_EMISSIVE, uv);
            values.specular = texture_fetch_use(specular_image, material, TEXTURE_SPECULAR, uv);
            values.specular_color =
                texture_fetch_use(specular_color_image, material, TEXTURE_SPECULAR_COLOR, uv);
#if NORMAL_MAPS
            values.normal = texture_fetch_use(normal_image, material, TEXTURE_NORMAL, uv);
#endif
#if LAYERS
            values.transmission =
                texture_fetch_use(transmission_image, material, TEXTURE_TRANSMISSION, uv);
            values.diffuse_transmission = texture_fetch_use(diffuse_transmission_image, material,
                                                            TEXTURE_DIFFUSE_TRANSMISSION, uv);
            values.diffuse_transmission_color = texture_fetch_use(
                diffuse_transmission_color_image, material, TEXTURE_DIFFUSE_TRANSMISSION_COLOR, uv);
            values.coat = texture_fetch_use(coat_image, material, TEXTURE_COAT, uv);
            values.coat_roughness =
                texture_fetch_use(coat_roughness_image, material, TEXTURE_COAT_ROUGHNESS, uv);
#if NORMAL_MAPS
            values.coat_normal =
                texture_fetch_use(coat_normal_image, material, TEXTURE_COAT_NORMAL, uv);
#endif
#endif
#if SHEEN_LOBE
            values.sheen_color =
                texture_fetch_use(sheen_color_image, material, TEXTURE_SHEEN_COLOR, uv);
            values.sheen_roughness =
                texture_fetch_use(sheen_roughness_image, material, TEXTURE_SHEEN_ROUGHNESS, uv);
#endif
#else
        material_fetch(&values, texels, material, uv);
#endif
            material_hit(settings, batch, bounce, &scene, slot, hit, &values, rays, paths, shades);
        }
#if MATERIAL_LANES
    }
#endif
}
