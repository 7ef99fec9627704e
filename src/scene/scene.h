/**
 * @file
 * A scene as the file describes it: metres, Y up, linear Rec. 709, photometric units as they stand
 * in the file.
 *
 * Made by gltf_import(); read by prep/. Everything lives in one arena and dies with scene_free().
 * Every index in it has been checked, every number is finite, every array has the length that its
 * count says.
 */
#ifndef SCENE_SCENE_H
#define SCENE_SCENE_H

#include <stdbool.h>
#include <stdint.h>

#include "core/arena.h"

#define SCENE_NONE (-1)

/** A decoded image, 8 bits a channel. */
struct scene_image {
    const char *name; // URI or name, for messages
    uint32_t width;   // 1 .. 65535
    uint32_t height;  // 1 .. 65535
    uint8_t *rgba;    // [width * height * 4], rows from the top
};

/** enum values equal those of shared/material.h: enum texture_wrap. */
struct scene_texture {
    int32_t image;   // index into images
    uint32_t wrap_s; // 0 repeat, 1 clamp to edge, 2 mirrored repeat
    uint32_t wrap_t;
    bool nearest; // magnification filter NEAREST
};

/** One use of a texture by a material. texture == SCENE_NONE: no texture, reads as 1. */
struct scene_texture_use {
    int32_t texture;    // index into textures, or SCENE_NONE
    uint32_t texcoord;  // 0 or 1
    float uv_matrix[4]; // KHR_texture_transform: u' = m0 u + m1 v + offset0, v' = m2 u + m3 v +
                        // offset1
    float uv_offset[2];
};

struct scene_material {
    const char *name;          // never NULL; "" if the file has none
    bool specular_glossiness;  // KHR_materials_pbrSpecularGlossiness, else metallic-roughness
    float base_color[4];       // base colour, or diffuse factor
    float metallic, roughness; // 0 .. 1
    float specular_color[3]; // specularColorFactor of KHR_materials_specular, or specularFactor of
                             // spec-gloss
    float specular_strength; // specularFactor of KHR_materials_specular, 1 if absent
    float glossiness;        // 0 .. 1
    float emission[3];       // emissiveFactor times KHR_materials_emissive_strength
    bool blended;            // alphaMode BLEND
    bool masked;             // alphaMode MASK
    float alpha_cutoff;
    bool double_sided;
    bool unlit;                            // KHR_materials_unlit
    struct scene_texture_use base_texture; // base colour or diffuse, sRGB
    struct scene_texture_use
        surface_texture; // metallicRoughness (linear), or specularGlossiness (rgb sRGB)
    struct scene_texture_use emissive_texture;       // sRGB
    struct scene_texture_use specular_texture;       // strength in a, linear
    struct scene_texture_use specular_color_texture; // sRGB
    struct scene_texture_use normal_texture;         // tangent space, linear
    float normal_scale;                              // of its x and y
    float transmission;                              // KHR_materials_transmission, 0 .. 1
    float diffuse_transmission;                      // KHR_materials_diffuse_transmission, 0 .. 1
    float diffuse_transmission_color[3];
    float coat, coat_roughness;                                  // KHR_materials_clearcoat, 0 .. 1
    struct scene_texture_use transmission_texture;               // r
    struct scene_texture_use diffuse_transmission_texture;       // a
    struct scene_texture_use diffuse_transmission_color_texture; // sRGB
    struct scene_texture_use coat_texture;                       // r
    struct scene_texture_use coat_roughness_texture;             // g
    struct scene_texture_use coat_normal_texture;                // tangent space
    float coat_normal_scale;                                     // of its x and y
    float sheen_color[3];                                        // KHR_materials_sheen, 0 .. 1
    float sheen_roughness;                                       // 0 .. 1
    struct scene_texture_use sheen_color_texture;                // sRGB
    struct scene_texture_use sheen_roughness_texture;            // a
};

/** One triangle list in its own space. Attributes that the file lacks are NULL, but normals are
 * always there. */
struct scene_mesh {
    const char *name; // mesh name and primitive number, for messages
    uint32_t vertex_count;
    uint32_t triangle_count;
    float *positions; // [vertex_count * 3]
    float *normals;   // [vertex_count * 3]; of the faces where the file has none (vertices are then
                      // split)
    float *tangents;  // [vertex_count * 4], unit, w 1 or -1 times cross(normal, tangent) gives the
                      // bitangent; NULL unless the material has a normal map
    float *uv0, *uv1; // [vertex_count * 2] or NULL
    float *colors; // [vertex_count * 4] COLOR_0, linear, alpha 1 where the file has none; or NULL
    uint32_t *indices; // [triangle_count * 3], below vertex_count
    uint32_t material; // index into materials
};

/** A mesh placed in the world. */
struct scene_instance {
    uint32_t mesh;       // index into meshes
    double to_world[12]; // 3x4, row major: world = M (x, y, z, 1)
};

enum scene_light_type {
    SCENE_LIGHT_POINT,
    SCENE_LIGHT_SPOT,
    SCENE_LIGHT_DIRECTIONAL,
    SCENE_LIGHT_RECTANGLE, // EXT_lights_area
    SCENE_LIGHT_DISC       // EXT_lights_area
};

/** KHR_lights_punctual or EXT_lights_area, placed in the world. The node's scale changes nothing
 * but the size of area lights. */
struct scene_light {
    const char *name;
    enum scene_light_type type;
    float color[3];        // colour times intensity: cd, lux (directional), or cd/m2 (area)
    float position[3];     // world, m
    float direction[3];    // world, unit: where the light goes (-Z of the node)
    float range;           // m; 0 if the file gives none
    float inner_angle_rad; // spot
    float outer_angle_rad; // spot
    float half_u[3]; // area: half edges or radii, world, m, at a right angle; the light shines
    float half_v[3]; // to where u x v points
};

struct scene_camera {
    const char *name;      // camera's name; "" if none
    const char *node_name; // node's name; "" if none
    bool orthographic;
    float yfov_rad;      // perspective: vertical field of view
    float aspect;        // width / height; 0 if the file leaves it open
    float xmag, ymag;    // orthographic: half width and half height, m
    double to_world[12]; // as scene_instance; looks along -Z, up is +Y; columns normalised by the
                         // reader
};

/** What lights the scene from far away: a lat-long image, cd/m2, placed as
 * shared/environment.h says. */
struct scene_environment {
    uint32_t width, height; // texels; 0 if the file gives none
    float *rgb;             // [width * height * 3], rows from the top
};

struct scene {
    struct arena arena; // owns all below
    const char *file;
    struct scene_image *images;
    struct scene_texture *textures;
    struct scene_material
        *materials; // at least one: the default material is appended where a mesh has none
    struct scene_mesh *meshes;
    struct scene_instance *instances;
    struct scene_light *lights;
    struct scene_camera *cameras;
    struct scene_environment environment; // EXT_lights_image_based
    uint32_t image_count, texture_count, material_count, mesh_count, instance_count, light_count,
        camera_count;
};

/** Whether some light may go straight through the material: thin transmission without roughness. An
 * emissive one scatters a little instead, so that every ray can meet what it emits. */
bool scene_material_transmits(const struct scene_material *material);

/** Releases everything the scene owns and leaves it empty. Safe on an empty scene. */
void scene_free(struct scene *scene);

#endif
