#include "scene/gltf_place.hpp"

#include <cmath>
#include <cstring>

#include "scene/gltf_accessor.hpp"
#include "scene/gltf_light.hpp"
#include "scene/gltf_mesh.hpp"
#include "scene/gltf_node.hpp"

static const double PI = 3.14159265358979323846;

// What 31-bit indices reach, all instances counted.
static const uint64_t MAX_INSTANCED = ((uint64_t)1 << 31) - 1;

// Meshes in their plain shape are read once, however often they are placed.
struct mesh_cache {
    std::vector<std::vector<loaded_primitive>> primitives; // [model.meshes.size()]
    std::vector<bool> is_loaded;                           // [model.meshes.size()]
    uint64_t triangles = 0;                                // of all instances
    uint64_t vertices = 0;                                 // of all instances
};

static std::string node_label(const import_context &context, int index)
{
    const size_t i = static_cast<size_t>(index);
    return label("node", i, context.model.nodes[i].name);
}

static bool has_targets(const tinygltf::Mesh &mesh)
{
    for (const tinygltf::Primitive &primitive : mesh.primitives) {
        if (!primitive.targets.empty())
            return true;
    }
    return false;
}

// The primitives of a node's mesh, in the shape that the node gives it.
static std::vector<loaded_primitive> node_primitives(import_context &context, mesh_cache &cache,
                                                     const tinygltf::Node &node,
                                                     const std::string &owner)
{
    if (static_cast<size_t>(node.mesh) >= context.model.meshes.size())
        fail_import(STATUS_FORMAT, "%s: there is no mesh %d", owner.c_str(), node.mesh);
    const size_t index = static_cast<size_t>(node.mesh);
    const tinygltf::Mesh &mesh = context.model.meshes[index];
    mesh_pose pose;
    if (has_targets(mesh)) {
        warn_once(context, "morph", "%s: morph targets are shown at their default weights",
                  label("mesh", index, mesh.name).c_str());
        pose.weights = node.weights.empty() ? &mesh.weights : &node.weights;
    }
    if (node.skin >= 0) {
        warn_once(context, "skin", "%s: skins are shown at rest", owner.c_str());
        pose.skin = node.skin;
    }
    if (pose.skin >= 0 || (pose.weights != nullptr && !node.weights.empty()))
        return load_mesh(context, node.mesh, pose);
    if (!cache.is_loaded[index]) {
        cache.primitives[index] = load_mesh(context, node.mesh, pose);
        cache.is_loaded[index] = true;
    }
    return cache.primitives[index];
}

static void add_instance(import_context &context, mesh_cache &cache, uint32_t mesh,
                         const double *to_world, const std::string &owner)
{
    scene_instance instance;
    instance.mesh = mesh;
    for (int i = 0; i < 12; i++) {
        finite_float(to_world[i], owner, "its place in the world");
        instance.to_world[i] = to_world[i];
    }
    cache.triangles += context.meshes[mesh].triangle_count;
    cache.vertices += context.meshes[mesh].vertex_count;
    if (cache.triangles > MAX_INSTANCED || cache.vertices > MAX_INSTANCED)
        fail_import(STATUS_LIMIT, "%s: the instances have more than 2^31 triangles or vertices",
                    owner.c_str());
    context.instances.push_back(instance);
}

// Reads one attribute of EXT_mesh_gpu_instancing; `count` is 0 before the first.
static void read_instancing(import_context &context, const tinygltf::Value &attributes,
                            const char *name, int components, const std::string &owner,
                            size_t *count, std::vector<float> *out)
{
    const int accessor = index_member(attributes, name, owner);
    if (accessor < 0)
        return;
    const std::string full = owner + ": " + name;
    const size_t found = checked_count(context, accessor, components, full);
    if (*count != 0 && found != *count)
        fail_import(STATUS_FORMAT, "%s has %zu elements, not %zu", full.c_str(), found, *count);
    *count = found;
    out->resize(found * static_cast<size_t>(components));
    read_floats(context, accessor, components, false, full, out->data());
}

// The transforms that EXT_mesh_gpu_instancing gives a node's mesh, 12 numbers each.
static std::vector<double> instancing_transforms(import_context &context,
                                                 const tinygltf::Value &extension,
                                                 const std::string &owner)
{
    std::vector<float> translations;
    std::vector<float> rotations;
    std::vector<float> scales;
    size_t count = 0;
    if (extension.Has("attributes")) {
        const tinygltf::Value &attributes = extension.Get(std::string("attributes"));
        read_instancing(context, attributes, "TRANSLATION", 3, owner, &count, &translations);
        read_instancing(context, attributes, "ROTATION", 4, owner, &count, &rotations);
        read_instancing(context, attributes, "SCALE", 3, owner, &count, &scales);
    }
    std::vector<double> transforms(count * 12);
    for (size_t i = 0; i < count; i++) {
        double translation[3] = {0.0, 0.0, 0.0};
        double quaternion[4] = {0.0, 0.0, 0.0, 1.0};
        double scale[3] = {1.0, 1.0, 1.0};
        for (size_t c = 0; c < 3 && !translations.empty(); c++)
            translation[c] = translations[i * 3 + c];
        for (size_t c = 0; c < 4 && !rotations.empty(); c++)
            quaternion[c] = rotations[i * 4 + c];
        for (size_t c = 0; c < 3 && !scales.empty(); c++)
            scale[c] = scales[i * 3 + c];
        compose_transform(translation, quaternion, scale, owner, &transforms[i * 12], nullptr);
    }
    return transforms;
}

static void place_mesh(import_context &context, mesh_cache &cache, int node_index)
{
    static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    const tinygltf::Node &node = context.model.nodes[static_cast<size_t>(node_index)];
    const node_pose &pose = context.poses[static_cast<size_t>(node_index)];
    const std::string owner = node_label(context, node_index);
    const tinygltf::Value *instancing = find_extension(node.extensions, "EXT_mesh_gpu_instancing");
    std::vector<double> transforms;
    if (instancing != nullptr)
        transforms = instancing_transforms(context, *instancing, owner);

    for (const loaded_primitive &primitive : node_primitives(context, cache, node, owner)) {
        if (instancing == nullptr)
            add_instance(context, cache, primitive.mesh,
                         primitive.is_in_world ? identity : pose.to_world, owner);
        for (size_t i = 0; i < transforms.size(); i += 12) {
            double to_world[12];
            multiply_transforms(pose.to_world, &transforms[i], to_world);
            add_instance(context, cache, primitive.mesh, to_world, owner);
        }
    }
}

static void place_camera(import_context &context, int node_index)
{
    const tinygltf::Node &node = context.model.nodes[static_cast<size_t>(node_index)];
    const std::string node_name = node_label(context, node_index);
    if (static_cast<size_t>(node.camera) >= context.model.cameras.size())
        fail_import(STATUS_FORMAT, "%s: there is no camera %d", node_name.c_str(), node.camera);
    const tinygltf::Camera &source = context.model.cameras[static_cast<size_t>(node.camera)];
    const std::string owner = label("camera", static_cast<size_t>(node.camera), source.name);
    scene_camera camera = {};
    camera.name = arena_text(context, source.name);
    camera.node_name = arena_text(context, node.name);
    camera.orthographic = source.type == "orthographic";
    if (camera.orthographic) {
        camera.xmag = std::fabs(finite_float(source.orthographic.xmag, owner, "xmag"));
        camera.ymag = std::fabs(finite_float(source.orthographic.ymag, owner, "ymag"));
        if (camera.xmag <= 0.0f || camera.ymag <= 0.0f)
            fail_import(STATUS_FORMAT, "%s: xmag or ymag is 0", owner.c_str());
    } else {
        camera.yfov_rad = finite_float(source.perspective.yfov, owner, "yfov");
        camera.aspect = finite_float(source.perspective.aspectRatio, owner, "aspectRatio");
        if (camera.yfov_rad <= 0.0f || camera.yfov_rad >= static_cast<float>(PI))
            fail_import(STATUS_FORMAT, "%s: yfov %g is not within 0 .. pi", owner.c_str(),
                        source.perspective.yfov);
        if (camera.aspect < 0.0f)
            fail_import(STATUS_FORMAT, "%s: aspectRatio %g is negative", owner.c_str(),
                        source.perspective.aspectRatio);
    }
    memcpy(camera.to_world, context.poses[static_cast<size_t>(node_index)].to_world,
           sizeof(camera.to_world));
    context.cameras.push_back(camera);
}

void place_contents(import_context &context, const std::vector<int> &nodes)
{
    mesh_cache cache;
    cache.primitives.resize(context.model.meshes.size());
    cache.is_loaded.resize(context.model.meshes.size());
    for (const int index : nodes) {
        const size_t i = static_cast<size_t>(index);
        if (context.model.nodes[i].camera >= 0)
            place_camera(context, index);
        if (!context.poses[i].is_visible)
            continue;
        if (context.model.nodes[i].mesh >= 0)
            place_mesh(context, cache, index);
        place_lights(context, index);
    }
}
