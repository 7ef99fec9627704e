#include "scene/scene.h"

void scene_free(struct scene *scene)
{
    arena_free(&scene->arena);
    *scene = (struct scene){0};
}
