#include "scene/gltf_light.hpp"

#include <cmath>

static const double PI = 3.14159265358979323846;

// Reads the cone of a spot light.
static void read_cone(const tinygltf::SpotLight &spot, const std::string &owner, scene_light &out)
{
    out.inner_angle_rad = finite_float(spot.innerConeAngle, owner, "innerConeAngle");
    out.outer_angle_rad = finite_float(spot.outerConeAngle, owner, "outerConeAngle");
    // Exporters write a right angle that rounding has carried a little further.
    const float right_angle = static_cast<float>(PI / 2.0);
    if (out.outer_angle_rad > right_angle && out.outer_angle_rad < right_angle + 1e-4f)
        out.outer_angle_rad = right_angle;
    if (out.inner_angle_rad < 0.0f || out.inner_angle_rad > out.outer_angle_rad ||
        out.outer_angle_rad <= 0.0f || out.outer_angle_rad > right_angle)
        fail_import(STATUS_FORMAT,
                    "%s: cone angles %g and %g are not 0 <= inner <= outer <= pi / 2",
                    owner.c_str(), spot.innerConeAngle, spot.outerConeAngle);
}

static scene_light convert_light(const tinygltf::Light &source, const std::string &owner)
{
    scene_light light = {};
    if (source.type == "point")
        light.type = SCENE_LIGHT_POINT;
    else if (source.type == "spot")
        light.type = SCENE_LIGHT_SPOT;
    else if (source.type == "directional")
        light.type = SCENE_LIGHT_DIRECTIONAL;
    else
        fail_import(STATUS_FORMAT, "%s: type \"%s\" does not exist", owner.c_str(),
                    source.type.c_str());
    if (!source.color.empty() && source.color.size() != 3)
        fail_import(STATUS_FORMAT, "%s: color has %zu numbers, not 3", owner.c_str(),
                    source.color.size());
    for (size_t i = 0; i < 3; i++) {
        const double channel = source.color.empty() ? 1.0 : source.color[i];
        light.color[i] = finite_float(channel * source.intensity, owner, "color times intensity");
        if (channel < 0.0 || source.intensity < 0.0)
            fail_import(STATUS_FORMAT, "%s: its color or intensity is negative", owner.c_str());
    }
    light.range = finite_float(source.range, owner, "range");
    if (light.range < 0.0f)
        fail_import(STATUS_FORMAT, "%s: range %g is negative", owner.c_str(), source.range);
    if (light.type == SCENE_LIGHT_SPOT)
        read_cone(source.spot, owner, light);
    return light;
}

// Where a node puts a light, and which way it shines.
static void set_pose(scene_light &light, const node_pose &pose, const std::string &owner)
{
    for (int i = 0; i < 3; i++) {
        light.position[i] = finite_float(pose.to_world[i * 4 + 3], owner, "its place in the world");
        light.direction[i] = static_cast<float>(-pose.rotation[i * 3 + 2]);
    }
}

// The index of the light that a node has by an extension, and the node's label; -1 if it has none.
static int find_light(std::string &owner, const tinygltf::Node &node, int node_index,
                      const char *name)
{
    const tinygltf::Value *extension = find_extension(node.extensions, name);
    if (extension == nullptr)
        return -1;
    owner = label("node", static_cast<size_t>(node_index), node.name);
    return index_member(*extension, "light", owner);
}

static void place_punctual(import_context &context, int node_index)
{
    const tinygltf::Node &node = context.model.nodes[static_cast<size_t>(node_index)];
    std::string owner;
    const int index = find_light(owner, node, node_index, "KHR_lights_punctual");
    if (index < 0)
        return;
    if (static_cast<size_t>(index) >= context.model.lights.size())
        fail_import(STATUS_FORMAT, "%s: there is no light %d", owner.c_str(), index);
    const tinygltf::Light &source = context.model.lights[static_cast<size_t>(index)];
    scene_light light =
        convert_light(source, label("light", static_cast<size_t>(index), source.name));
    light.name = arena_text(context, source.name.empty() ? node.name : source.name);
    set_pose(light, context.poses[static_cast<size_t>(node_index)], owner);
    context.lights.push_back(light);
}

// The largest of a transform's scales along the axes.
static double largest_scale(const double *to_world)
{
    double largest = 0.0;
    for (int column = 0; column < 3; column++) {
        const double x = to_world[column];
        const double y = to_world[4 + column];
        const double z = to_world[8 + column];
        largest = std::fmax(largest, std::sqrt(x * x + y * y + z * z));
    }
    return largest;
}

// Reads a size of an area light, which must be greater than 0.
static double read_size(const tinygltf::Value &object, const char *name, const std::string &owner)
{
    const double size = number_member(object, name, 1.0, owner);
    if (!(size > 0.0))
        fail_import(STATUS_FORMAT, "%s: %s %g is not greater than 0", owner.c_str(), name, size);
    return size;
}

// Reads an area light: colour, and its width and height before the node scales it.
static scene_light convert_area(const tinygltf::Value &source, const std::string &owner,
                                double *width, double *height)
{
    scene_light light = {};
    std::string type;
    if (source.Has("type") && source.Get(std::string("type")).IsString())
        type = source.Get(std::string("type")).Get<std::string>();
    if (type == "rect")
        light.type = SCENE_LIGHT_RECTANGLE;
    else if (type == "disk")
        light.type = SCENE_LIGHT_DISC;
    else
        fail_import(STATUS_FORMAT, "%s: type \"%s\" does not exist", owner.c_str(), type.c_str());

    const double intensity = number_member(source, "intensity", 1000.0, owner);
    float color[3] = {1.0f, 1.0f, 1.0f};
    numbers_member(source, "color", color, 3, owner);
    for (size_t i = 0; i < 3; i++) {
        light.color[i] = finite_float(color[i] * intensity, owner, "color times intensity");
        if (color[i] < 0.0f || intensity < 0.0)
            fail_import(STATUS_FORMAT, "%s: its color or intensity is negative", owner.c_str());
    }
    *width = *height = read_size(source, "size", owner);
    if (light.type == SCENE_LIGHT_RECTANGLE && source.Has("rect"))
        *width *= read_size(source.Get(std::string("rect")), "aspect", owner);
    return light;
}

static void place_area(import_context &context, int node_index)
{
    const tinygltf::Node &node = context.model.nodes[static_cast<size_t>(node_index)];
    std::string owner;
    const int index = find_light(owner, node, node_index, "EXT_lights_area");
    if (index < 0)
        return;
    const tinygltf::Value *root = find_extension(context.model.extensions, "EXT_lights_area");
    const tinygltf::Value none;
    const tinygltf::Value &lights =
        root != nullptr && root->Has("lights") ? root->Get(std::string("lights")) : none;
    if (!lights.IsArray() || static_cast<size_t>(index) >= lights.ArrayLen())
        fail_import(STATUS_FORMAT, "%s: there is no area light %d", owner.c_str(), index);

    double width = 0.0;
    double height = 0.0;
    const tinygltf::Value &source = lights.Get(index);
    scene_light light =
        convert_area(source, label("area light", static_cast<size_t>(index), ""), &width, &height);
    const node_pose &pose = context.poses[static_cast<size_t>(node_index)];
    const double scale = largest_scale(pose.to_world);
    set_pose(light, pose, owner);
    for (int i = 0; i < 3; i++) {
        // Y x X points along -Z, where the light goes.
        light.half_u[i] =
            finite_float(0.5 * height * scale * pose.rotation[i * 3 + 1], owner, "its size");
        light.half_v[i] =
            finite_float(0.5 * width * scale * pose.rotation[i * 3], owner, "its size");
    }
    light.name = arena_text(context, node.name);
    context.lights.push_back(light);
}

void place_lights(import_context &context, int node_index)
{
    place_punctual(context, node_index);
    place_area(context, node_index);
}
