/**
 * @file
 * Materials and their textures as kernels read them.
 *
 * Both of glTF's workflows are kept as the file gives them; the material stage turns them into one
 * set of BSDF parameters after the textures are fetched.
 */
#ifndef SHARED_MATERIAL_H
#define SHARED_MATERIAL_H

#include "shared/base.h"

// Textures of one material, by what they mean; (sRGB) ones are decoded to linear before filtering.
enum texture_use {
    TEXTURE_BASE = 0,     // rgb base or diffuse colour (sRGB), a alpha (linear)
    TEXTURE_SURFACE = 1,  // metallic-roughness: g roughness, b metalness; specular-glossiness: rgb
                          // specular colour (sRGB), a glossiness
    TEXTURE_EMISSIVE = 2, // rgb (sRGB)
    TEXTURE_SPECULAR = 3, // a: strength of KHR_materials_specular
    TEXTURE_SPECULAR_COLOR = 4, // rgb (sRGB)
    TEXTURE_NORMAL = 5,         // tangent space; those from here on only in kernels that need them
    TEXTURE_TRANSMISSION = 6,   // r
    TEXTURE_DIFFUSE_TRANSMISSION = 7,       // a
    TEXTURE_DIFFUSE_TRANSMISSION_COLOR = 8, // rgb (sRGB)
    TEXTURE_COAT = 9,                       // r
    TEXTURE_COAT_ROUGHNESS = 10,            // g
    TEXTURE_COAT_NORMAL = 11,               // tangent space
    TEXTURE_SHEEN_COLOR = 12,               // rgb (sRGB)
    TEXTURE_SHEEN_ROUGHNESS = 13,           // a
    TEXTURE_USE_COUNT = 14
};

// texture_slot.flags
#define TEXTURE_PRESENT      1u // else the slot reads as 1, 1, 1, 1
#define TEXTURE_UV1          2u // reads TEXCOORD_1, else TEXCOORD_0
#define TEXTURE_NEAREST      4u // magnified without filtering, else bilinear
#define TEXTURE_SRGB         8u // rgb are sRGB coded; a never is
#define TEXTURE_WRAP_S_SHIFT 4u // two bits of enum texture_wrap
#define TEXTURE_WRAP_T_SHIFT 6u

enum texture_wrap { TEXTURE_WRAP_REPEAT = 0, TEXTURE_WRAP_CLAMP = 1, TEXTURE_WRAP_MIRROR = 2 };

// One use of one texture: where its texels are, and how a UV reaches them.
struct texture_slot {
    float4 uv_matrix; // u' = x u + y v + uv_offset.x, v' = z u + w v + uv_offset.y
                      // (KHR_texture_transform)
    float2 uv_offset;
    uint texel_first; // index of the first texel in the pool: RGBA, 8 bits each, r lowest; rows
                      // from the top
    uint size;        // width | height << 16, texels, both 1 .. 65535
    uint flags;       // TEXTURE_...
    uint pad0, pad1, pad2;
};
SHARED_SIZE(texture_slot, 48);

// material.flags
#define MATERIAL_SPECULAR_GLOSSINESS 1u    // else metallic-roughness
#define MATERIAL_MASKED              2u    // alpha below the cut-off is not there
#define MATERIAL_EMITS_BACK          4u    // emits on both sides
#define MATERIAL_UNLIT               8u    // shows its base colour, reflects nothing
#define MATERIAL_VERTEX_COLOR        16u   // multiply with vertex_colors[]
#define MATERIAL_BLENDED             32u   // alpha is the share of rays that meet it
#define MATERIAL_NORMAL_MAP          64u   // TEXTURE_NORMAL bends the shading normal
#define MATERIAL_LAYERED             128u  // has some of lib/layers.h
#define MATERIAL_TRANSMITS           256u  // thin: some light goes through, unscattered if smooth
#define MATERIAL_COAT_NORMAL_MAP     512u  // TEXTURE_COAT_NORMAL bends the clearcoat's normal
#define MATERIAL_SHEEN               1024u // has a sheen; MATERIAL_LAYERED, too
#define MATERIAL_LAMBERT             2048u // specular lobe of strength 0, whatever its textures say

// What CPUs shade hit by hit, among the flags.
#define MATERIAL_APART (MATERIAL_UNLIT | MATERIAL_COAT_NORMAL_MAP | MATERIAL_LAYERED)

// What else no kernel of whole paths (cl/paths.cl) shades.
#define MATERIAL_EXTRAS (MATERIAL_APART | MATERIAL_VERTEX_COLOR | MATERIAL_NORMAL_MAP)

// Roughness squared up to which a surface is smooth: below it GGX's D leaves float's range at
// grazing views.
#define MATERIAL_SMOOTH 1e-3f

struct material {
    float4 base;     // rgb factor of base or diffuse colour, linear; a factor of alpha
    float4 emission; // rgb radiance factor, emissive_strength included; w alpha cut-off
    float4
        specular; // rgb factor of specular colour; w strength (KHR_materials_specular, 1 if absent)
    float4 diffuse_transmission; // rgb factor of its colour; w factor, 0 .. 1
    float4 sheen;                // rgb factor of its colour; w factor of its roughness, 0 .. 1
    float metallic;              // factor, 0 .. 1
    float roughness;             // factor, 0 .. 1
    float glossiness;            // factor, 0 .. 1
    uint flags;                  // MATERIAL_...
    float normal_scale;          // of the normal map's x and y
    float transmission;          // factor, 0 .. 1
    float coat;                  // factor, 0 .. 1
    float coat_roughness;        // factor, 0 .. 1
    float coat_normal_scale;     // of its normal map's x and y
    uint pad0, pad1, pad2;
    struct texture_slot textures[TEXTURE_USE_COUNT];
};
SHARED_SIZE(material, 800);

#endif
