#include "scene/gltf_mesh.hpp"

#include <algorithm>
#include <cstring>

#include "scene/gltf_accessor.hpp"
#include "scene/gltf_material.hpp"
#include "scene/gltf_shape.hpp"
#include "scene/gltf_tangent.hpp"

// What 31-bit indices reach: BVH_REF_TRIANGLE and the vertices of all meshes.
static const uint64_t MAX_TOTAL = ((uint64_t)1 << 31) - 1;

// Reads an attribute into the arena; NULL if the primitive lacks it.
static float *read_attribute(import_context &context, const tinygltf::Primitive &primitive,
                             const char *name, int components, size_t vertex_count,
                             const std::string &owner)
{
    const auto found = primitive.attributes.find(name);
    if (found == primitive.attributes.end())
        return nullptr;
    const std::string full = owner + ": " + name;
    const size_t count = checked_count(context, found->second, components, full);
    if (count != vertex_count)
        fail_import(STATUS_FORMAT, "%s has %zu elements, but POSITION has %zu", full.c_str(), count,
                    vertex_count);
    float *values = arena_array<float>(context, count * static_cast<size_t>(components));
    read_floats(context, found->second, components, false, full, values);
    return values;
}

// Reads COLOR_0 with three or four components; alpha is 1 where there are three.
static float *read_colors(import_context &context, const tinygltf::Primitive &primitive,
                          size_t vertex_count, const std::string &owner)
{
    const auto found = primitive.attributes.find("COLOR_0");
    if (found == primitive.attributes.end())
        return nullptr;
    const std::string full = owner + ": COLOR_0";
    const tinygltf::Accessor &accessor = find_accessor(context, found->second, full);
    const int components = component_count(accessor) == 3 ? 3 : 4;
    if (checked_count(context, found->second, components, full) != vertex_count)
        fail_import(STATUS_FORMAT, "%s has %zu elements, but POSITION has %zu", full.c_str(),
                    accessor.count, vertex_count);
    float *colors = arena_array<float>(context, vertex_count * 4);
    const bool is_whole = accessor.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT;
    read_floats(context, found->second, components, is_whole, full, colors);
    // Spread threes to fours in place, from the end.
    for (size_t v = vertex_count; components == 3 && v-- > 0;) {
        const float rgb[3] = {colors[v * 3], colors[v * 3 + 1], colors[v * 3 + 2]};
        memcpy(colors + v * 4, rgb, sizeof(rgb));
        colors[v * 4 + 3] = 1.0f;
    }
    return colors;
}

static shape read_shape(import_context &context, const tinygltf::Primitive &primitive,
                        const std::string &owner)
{
    shape shape;
    const std::string name = owner + ": POSITION";
    shape.vertex_count = checked_count(context, primitive.attributes.at("POSITION"), 3, name);
    shape.positions = read_attribute(context, primitive, "POSITION", 3, shape.vertex_count, owner);
    shape.normals = read_attribute(context, primitive, "NORMAL", 3, shape.vertex_count, owner);
    if (normal_map_texcoord(context, primitive.material) >= 0)
        shape.tangents =
            read_attribute(context, primitive, "TANGENT", 4, shape.vertex_count, owner);
    shape.uv0 = read_attribute(context, primitive, "TEXCOORD_0", 2, shape.vertex_count, owner);
    shape.uv1 = read_attribute(context, primitive, "TEXCOORD_1", 2, shape.vertex_count, owner);
    shape.colors = read_colors(context, primitive, shape.vertex_count, owner);
    return shape;
}

// The vertices in drawing order, all below vertex_count.
static std::vector<uint32_t> read_indices(import_context &context,
                                          const tinygltf::Primitive &primitive, size_t vertex_count,
                                          const std::string &owner)
{
    std::vector<uint32_t> indices;
    if (primitive.indices < 0) {
        indices.resize(vertex_count);
        for (size_t i = 0; i < vertex_count; i++)
            indices[i] = static_cast<uint32_t>(i);
        return indices;
    }
    const std::string name = owner + ": indices";
    const tinygltf::Accessor &accessor = find_accessor(context, primitive.indices, name);
    indices.resize(checked_count(context, primitive.indices, 1, name));
    read_integers(context, primitive.indices, 1, name, indices.data());
    const uint32_t restart = accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ? 0xff
                             : accessor.componentType == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT
                                 ? 0xffff
                                 : 0xffffffff;
    for (size_t i = 0; i < indices.size(); i++) {
        if (indices[i] == restart)
            fail_import(STATUS_FORMAT,
                        "%s: index %zu is the primitive restart value %u, which "
                        "glTF forbids",
                        name.c_str(), i, restart);
        if (indices[i] >= vertex_count)
            fail_import(STATUS_FORMAT, "%s: index %zu is %u, but there are %zu vertices",
                        name.c_str(), i, indices[i], vertex_count);
    }
    return indices;
}

// Unrolls strips and fans to lists (glTF 2.0, section 3.7.2.1).
static std::vector<uint32_t> make_list(std::vector<uint32_t> drawn, int mode)
{
    if (mode == TINYGLTF_MODE_TRIANGLES) {
        drawn.resize(drawn.size() / 3 * 3);
        return drawn;
    }
    std::vector<uint32_t> list;
    const size_t count = drawn.size() < 3 ? 0 : drawn.size() - 2;
    list.reserve(count * 3);
    for (size_t i = 0; i < count; i++) {
        const bool is_strip = mode == TINYGLTF_MODE_TRIANGLE_STRIP;
        list.push_back(is_strip ? drawn[i] : drawn[i + 1]);
        list.push_back(is_strip ? drawn[i + 1 + i % 2] : drawn[i + 2]);
        list.push_back(is_strip ? drawn[i + 2 - i % 2] : drawn[0]);
    }
    return list;
}

// Gathers the values of each corner, so that no two triangles share a vertex.
static float *split_values(import_context &context, const float *values, size_t components,
                           const std::vector<uint32_t> &list)
{
    if (values == nullptr)
        return nullptr;
    float *split = arena_array<float>(context, list.size() * components);
    for (size_t i = 0; i < list.size(); i++)
        memcpy(split + i * components, values + list[i] * components, components * sizeof(float));
    return split;
}

// Gives a shape without normals those of its faces.
static void make_flat(import_context &context, shape &shape, std::vector<uint32_t> &list)
{
    shape.positions = split_values(context, shape.positions, 3, list);
    shape.tangents = nullptr; // glTF: tangents without normals are to be ignored
    shape.uv0 = split_values(context, shape.uv0, 2, list);
    shape.uv1 = split_values(context, shape.uv1, 2, list);
    shape.colors = split_values(context, shape.colors, 4, list);
    shape.vertex_count = list.size();
    shape.normals = arena_array<float>(context, list.size() * 3);
    for (size_t i = 0; i < list.size(); i += 3) {
        const float *const corner = shape.positions + i * 3;
        float *const normal = shape.normals + i * 3;
        face_normal(corner, corner + 3, corner + 6, normal);
        memcpy(normal + 3, normal, 3 * sizeof(float));
        memcpy(normal + 6, normal, 3 * sizeof(float));
    }
    for (size_t i = 0; i < list.size(); i++)
        list[i] = static_cast<uint32_t>(i);
}

// Can this primitive be drawn? Warns where it cannot.
static bool is_drawable(import_context &context, const tinygltf::Primitive &primitive,
                        const std::string &owner)
{
    if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        fail_import(STATUS_FORMAT, "%s: mode %d does not exist", owner.c_str(), primitive.mode);
    if (primitive.mode < TINYGLTF_MODE_TRIANGLES) {
        warn_once(context, "points", "%s: points and lines are not drawn", owner.c_str());
        return false;
    }
    if (primitive.attributes.count("POSITION") == 0) {
        warn_once(context, "positions", "%s has no POSITION and is not drawn", owner.c_str());
        return false;
    }
    return true;
}

// Turns a shape and its triangles into a mesh of the scene.
static scene_mesh finish_mesh(import_context &context, const shape &shape,
                              const std::vector<uint32_t> &list, const std::string &owner)
{
    context.vertex_total += shape.vertex_count;
    context.triangle_total += list.size() / 3;
    if (context.vertex_total > MAX_TOTAL || context.triangle_total > MAX_TOTAL)
        fail_import(STATUS_LIMIT, "%s: the scene has more than 2^31 vertices or triangles",
                    owner.c_str());
    scene_mesh mesh = {};
    mesh.name = arena_text(context, owner);
    mesh.vertex_count = static_cast<uint32_t>(shape.vertex_count);
    mesh.triangle_count = static_cast<uint32_t>(list.size() / 3);
    mesh.positions = shape.positions;
    mesh.normals = shape.normals;
    mesh.tangents = shape.tangents;
    mesh.uv0 = shape.uv0;
    mesh.uv1 = shape.uv1;
    mesh.colors = shape.colors;
    mesh.indices = arena_array<uint32_t>(context, list.size());
    if (!list.empty())
        memcpy(mesh.indices, list.data(), list.size() * sizeof(uint32_t));
    return mesh;
}

// Reads one primitive; false if there is nothing to draw.
static bool load_primitive(import_context &context, const tinygltf::Primitive &primitive,
                           const mesh_pose &pose, const std::string &owner, scene_mesh *out,
                           bool *is_in_world)
{
    if (!is_drawable(context, primitive, owner))
        return false;
    shape shape = read_shape(context, primitive, owner);
    std::vector<uint32_t> drawn = read_indices(context, primitive, shape.vertex_count, owner);
    const bool is_odd =
        primitive.mode == TINYGLTF_MODE_TRIANGLES ? drawn.size() % 3 != 0 : drawn.size() < 3;
    if (is_odd)
        warn_once(context, "odd",
                  "%s: %zu indices do not make whole triangles; the rest is left "
                  "out",
                  owner.c_str(), drawn.size());
    std::vector<uint32_t> list = make_list(std::move(drawn), primitive.mode);
    if (list.empty())
        return false;

    if (pose.weights != nullptr)
        apply_morph(context, primitive, *pose.weights, owner, shape);
    *is_in_world = pose.skin >= 0 && apply_skin(context, primitive, pose.skin, owner, shape);
    if (shape.normals != nullptr)
        normalize_normals(context, owner, shape, list.data(), list.size() / 3);
    else
        make_flat(context, shape, list);
    const int texcoord = normal_map_texcoord(context, primitive.material);
    if (texcoord >= 0 && shape.tangents != nullptr)
        repair_tangents(shape);
    else if (texcoord >= 0)
        make_tangents(context, shape, texcoord == 1 ? shape.uv1 : shape.uv0, list);
    *out = finish_mesh(context, shape, list, owner);
    out->material = use_material(context, primitive.material, owner);
    return true;
}

std::vector<loaded_primitive> load_mesh(import_context &context, int mesh_index,
                                        const mesh_pose &pose)
{
    const tinygltf::Mesh &mesh = context.model.meshes[static_cast<size_t>(mesh_index)];
    const std::string name = label("mesh", static_cast<size_t>(mesh_index), mesh.name);
    std::vector<loaded_primitive> loaded;
    for (size_t i = 0; i < mesh.primitives.size(); i++) {
        scene_mesh made;
        bool is_in_world = false;
        const std::string owner = name + ", primitive " + std::to_string(i);
        if (!load_primitive(context, mesh.primitives[i], pose, owner, &made, &is_in_world))
            continue;
        loaded.push_back({static_cast<uint32_t>(context.meshes.size()), is_in_world});
        context.meshes.push_back(made);
    }
    return loaded;
}
