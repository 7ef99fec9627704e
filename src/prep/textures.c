#include "prep/textures.h"

#include <stdlib.h>

#include "prep/array.h"

#define IMAGE_UNUSED UINT64_MAX // first texel of an image that no material uses

// The uses of a material, in the order of enum texture_use.
static void list_uses(const struct scene_texture_use *out[TEXTURE_USE_COUNT],
                      const struct scene_material *material)
{
    out[TEXTURE_BASE] = &material->base_texture;
    out[TEXTURE_SURFACE] = &material->surface_texture;
    out[TEXTURE_EMISSIVE] = &material->emissive_texture;
    out[TEXTURE_SPECULAR] = &material->specular_texture;
    out[TEXTURE_SPECULAR_COLOR] = &material->specular_color_texture;
    out[TEXTURE_NORMAL] = &material->normal_texture;
    out[TEXTURE_TRANSMISSION] = &material->transmission_texture;
    out[TEXTURE_DIFFUSE_TRANSMISSION] = &material->diffuse_transmission_texture;
    out[TEXTURE_DIFFUSE_TRANSMISSION_COLOR] = &material->diffuse_transmission_color_texture;
    out[TEXTURE_COAT] = &material->coat_texture;
    out[TEXTURE_COAT_ROUGHNESS] = &material->coat_roughness_texture;
    out[TEXTURE_COAT_NORMAL] = &material->coat_normal_texture;
    out[TEXTURE_SHEEN_COLOR] = &material->sheen_color_texture;
    out[TEXTURE_SHEEN_ROUGHNESS] = &material->sheen_roughness_texture;
}

// The image of a use; SCENE_NONE if there is none.
static int32_t image_of(const struct scene *scene, const struct scene_texture_use *use)
{
    return use->texture != SCENE_NONE ? scene->textures[use->texture].image : SCENE_NONE;
}

// Gives each image in use its place in the pool, in the order of the file. Returns the texels of
// all.
static uint64_t place_images(uint64_t *first, const struct scene *scene)
{
    for (uint32_t i = 0; i < scene->image_count; i++)
        first[i] = IMAGE_UNUSED;
    for (uint32_t i = 0; i < scene->material_count; i++) {
        const struct scene_texture_use *uses[TEXTURE_USE_COUNT];
        list_uses(uses, &scene->materials[i]);
        for (int use = 0; use < TEXTURE_USE_COUNT; use++) {
            const int32_t image = image_of(scene, uses[use]);
            if (image != SCENE_NONE)
                first[image] = 0;
        }
    }

    uint64_t next = 0;
    for (uint32_t i = 0; i < scene->image_count; i++) {
        if (first[i] == IMAGE_UNUSED)
            continue;
        first[i] = next;
        next += (uint64_t)scene->images[i].width * scene->images[i].height;
    }
    return next;
}

static void pack_slot(struct texture_slot *out, const struct scene *scene,
                      const struct scene_texture_use *use, bool srgb, const uint64_t *first)
{
    *out = (struct texture_slot){.uv_matrix = {1.0f, 0.0f, 0.0f, 1.0f}};
    const int32_t image = image_of(scene, use);
    if (image == SCENE_NONE)
        return;

    const struct scene_texture *texture = &scene->textures[use->texture];
    const float *m = use->uv_matrix;
    out->uv_matrix = (float4){m[0], m[1], m[2], m[3]};
    out->uv_offset = (float2){use->uv_offset[0], use->uv_offset[1]};
    out->texel_first = (uint)first[image];
    out->size = scene->images[image].width | scene->images[image].height << 16;
    out->flags = TEXTURE_PRESENT | (use->texcoord == 1 ? TEXTURE_UV1 : 0u) |
                 (texture->nearest ? TEXTURE_NEAREST : 0u) | (srgb ? TEXTURE_SRGB : 0u) |
                 texture->wrap_s << TEXTURE_WRAP_S_SHIFT | texture->wrap_t << TEXTURE_WRAP_T_SHIFT;
}

static uint layer_flags(const struct scene_material *material)
{
    const float *color = material->sheen_color;
    const bool sheen = color[0] > 0.0f || color[1] > 0.0f || color[2] > 0.0f;
    const bool layered = material->transmission > 0.0f || material->diffuse_transmission > 0.0f ||
                         material->coat > 0.0f || sheen;
    if (!layered || material->unlit)
        return 0u;
    const bool bent_coat =
        material->coat > 0.0f && material->coat_normal_texture.texture != SCENE_NONE;
    return MATERIAL_LAYERED | (sheen ? MATERIAL_SHEEN : 0u) |
           (bent_coat ? MATERIAL_COAT_NORMAL_MAP : 0u) |
           (scene_material_transmits(material) ? MATERIAL_TRANSMITS : 0u);
}

// Whether the factors leave nothing but the Lambert term.
static bool is_lambert(const struct scene_material *material)
{
    const float *color = material->specular_color;
    if (material->specular_glossiness)
        return color[0] == 0.0f && color[1] == 0.0f && color[2] == 0.0f;
    return material->specular_strength == 0.0f && material->metallic == 0.0f;
}

static void pack_material(struct material *out, const struct scene *scene,
                          const struct scene_material *material, const uint64_t *first)
{
    const float *base = material->base_color;
    const float *emission = material->emission;
    const float *specular = material->specular_color;
    const float *through = material->diffuse_transmission_color;
    const float *sheen = material->sheen_color;
    *out = (struct material){
        .base = {base[0], base[1], base[2], base[3]},
        .emission = {emission[0], emission[1], emission[2], material->alpha_cutoff},
        .specular = {specular[0], specular[1], specular[2], material->specular_strength},
        .diffuse_transmission = {through[0], through[1], through[2],
                                 material->diffuse_transmission},
        .sheen = {sheen[0], sheen[1], sheen[2], material->sheen_roughness},
        .metallic = material->metallic,
        .roughness = material->roughness,
        .glossiness = material->glossiness,
        .flags = (material->specular_glossiness ? MATERIAL_SPECULAR_GLOSSINESS : 0u) |
                 (material->masked ? MATERIAL_MASKED : 0u) |
                 (material->blended ? MATERIAL_BLENDED : 0u) |
                 (material->double_sided ? MATERIAL_EMITS_BACK : 0u) |
                 (material->unlit ? MATERIAL_UNLIT : 0u) | layer_flags(material) |
                 (is_lambert(material) ? MATERIAL_LAMBERT : 0u) |
                 (material->normal_texture.texture != SCENE_NONE ? MATERIAL_NORMAL_MAP : 0u),
        .normal_scale = material->normal_scale,
        .transmission = material->transmission,
        .coat = material->coat,
        .coat_roughness = material->coat_roughness,
        .coat_normal_scale = material->coat_normal_scale,
    };

    const bool srgb[TEXTURE_USE_COUNT] = {
        [TEXTURE_BASE] = true,           [TEXTURE_SURFACE] = material->specular_glossiness,
        [TEXTURE_EMISSIVE] = true,       [TEXTURE_SPECULAR] = false,
        [TEXTURE_SPECULAR_COLOR] = true, [TEXTURE_DIFFUSE_TRANSMISSION_COLOR] = true,
        [TEXTURE_SHEEN_COLOR] = true,
    };
    const struct scene_texture_use *uses[TEXTURE_USE_COUNT];
    list_uses(uses, material);
    for (int use = 0; use < TEXTURE_USE_COUNT; use++)
        pack_slot(&out->textures[use], scene, uses[use], srgb[use], first);
}

static void pack_texels(uint32_t *out, const struct scene_image *image)
{
    const int64_t count = (int64_t)image->width * image->height;
#pragma omp parallel for schedule(static)
    for (int64_t i = 0; i < count; i++) {
        const uint8_t *texel = image->rgba + 4 * i;
        out[i] = (uint32_t)texel[0] | (uint32_t)texel[1] << 8 | (uint32_t)texel[2] << 16 |
                 (uint32_t)texel[3] << 24;
    }
}

// Fills the arrays of a set that has been allocated.
static void fill(struct material_set *set, const struct scene *scene, const uint64_t *first)
{
    for (uint32_t i = 0; i < scene->material_count; i++)
        pack_material(&set->materials[i], scene, &scene->materials[i], first);
    for (uint32_t i = 0; i < scene->mesh_count; i++)
        if (scene->meshes[i].colors != NULL)
            set->materials[scene->meshes[i].material].flags |= MATERIAL_VERTEX_COLOR;
    for (uint32_t i = 0; i < scene->image_count; i++)
        if (first[i] != IMAGE_UNUSED)
            pack_texels(set->texels + first[i], &scene->images[i]);
}

enum status material_set_build(struct material_set *out, const struct scene *scene)
{
    enum status status = STATUS_OK;
    struct material_set set = {.material_count = scene->material_count};
    uint64_t *first = array_alloc(scene->image_count, sizeof(*first)); // first texel of each image
    if (first == NULL)
        return status_fail(STATUS_NO_MEMORY, "no memory for %u images", scene->image_count);

    set.texel_count = place_images(first, scene);
    if (set.texel_count > UINT32_MAX) {
        status = status_fail(STATUS_LIMIT, "the images in use have %.3g texels, more than %.3g",
                             (double)set.texel_count, (double)UINT32_MAX);
        goto cleanup;
    }
    set.materials = array_alloc(set.material_count, sizeof(*set.materials));
    set.texels = array_alloc(set.texel_count, sizeof(*set.texels));
    if (set.materials == NULL || set.texels == NULL) {
        status = status_fail(STATUS_NO_MEMORY, "no memory for %u materials and %.3g texels",
                             set.material_count, (double)set.texel_count);
        goto cleanup;
    }

    fill(&set, scene, first);
    *out = set;
    set = (struct material_set){0}; // the caller owns it now

cleanup:
    material_set_free(&set);
    free(first);
    return status;
}

void material_set_free(struct material_set *set)
{
    free(set->texels);
    free(set->materials);
    *set = (struct material_set){0};
}
