#include "scene/scene.h"

#include "shared/material.h"

bool scene_material_transmits(const struct scene_material *material)
{
    const float *emission = material->emission;
    const bool emits = emission[0] > 0.0f || emission[1] > 0.0f || emission[2] > 0.0f;
    const bool smooth = material->roughness * material->roughness <= MATERIAL_SMOOTH ||
                        material->surface_texture.texture != SCENE_NONE;
    return material->transmission > 0.0f && smooth && !emits && !material->unlit;
}

void scene_free(struct scene *scene)
{
    arena_free(&scene->arena);
    *scene = (struct scene){0};
}
