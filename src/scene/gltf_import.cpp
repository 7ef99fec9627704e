#include <cstring>
#include <new>
#include <stdexcept>

#include "scene/gltf_document.hpp"
#include "scene/gltf_environment.hpp"
#include "scene/gltf_material.hpp"
#include "scene/gltf_node.hpp"
#include "scene/gltf_place.hpp"

extern "C" {
#include "scene/gltf_import.h"
}

// Copies a list into the scene's arena.
template <typename T>
static void store(import_context &context, const std::vector<T> &from, T **array, uint32_t *count)
{
    *array = arena_array<T>(context, from.size());
    for (size_t i = 0; i < from.size(); i++)
        (*array)[i] = from[i];
    *count = static_cast<uint32_t>(from.size());
}

// Imports into context.scene; failures are thrown.
static void import_scene(import_context &context)
{
    struct scene *const scene = context.scene;
    scene->file = arena_text(context, context.path);
    load_document(context);
    if (context.has_animations)
        warn_once(context, "animations", "animations are ignored; the scene is shown at rest");

    // Nodes tell which meshes are needed, meshes which materials, materials which images.
    context.material_used.resize(context.model.materials.size() + 1);
    context.material_used.back() = context.model.materials.empty();
    place_nodes(context);
    place_contents(context, scene_nodes(context));
    if (context.instances.empty())
        warn_once(context, "empty", "it shows no triangles");
    load_materials(context);
    load_environment(context);

    store(context, context.meshes, &scene->meshes, &scene->mesh_count);
    store(context, context.instances, &scene->instances, &scene->instance_count);
    store(context, context.lights, &scene->lights, &scene->light_count);
    store(context, context.cameras, &scene->cameras, &scene->camera_count);
    store(context, context.materials, &scene->materials, &scene->material_count);
    store(context, context.textures, &scene->textures, &scene->texture_count);
}

enum status gltf_import(struct scene *out, const char *path)
{
    struct scene scene = {};
    enum status status = STATUS_OK;
    const char *const name = strcmp(path, "-") == 0 ? "standard input" : path;
    try {
        import_context context;
        context.path = path;
        context.name = name;
        context.scene = &scene;
        import_scene(context);
    } catch (const import_failure &failure) {
        status = status_fail(failure.code, "%s: %s", name, failure.message.c_str());
    } catch (const std::bad_alloc &) {
        status = status_fail(STATUS_NO_MEMORY, "%s: it does not fit", name);
    } catch (const std::length_error &) {
        status = status_fail(STATUS_NO_MEMORY, "%s: it does not fit", name);
    } catch (const std::exception &error) {
        status = status_fail(STATUS_FORMAT, "%s: %s", name, error.what());
    } catch (...) {
        status = status_fail(STATUS_FORMAT, "%s: it cannot be understood", name);
    }
    if (status == STATUS_OK)
        *out = scene; // the caller owns it now
    else
        scene_free(&scene);
    return status;
}
