#include "scene/gltf_node.hpp"

#include <cmath>
#include <cstring>

// How far the last row of a node's matrix may be from 0, 0, 0, 1.
static const double LAST_ROW_TOLERANCE = 1e-5;

void multiply_transforms(const double *a, const double *b, double *out)
{
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 4; column++) {
            double sum = column == 3 ? a[row * 4 + 3] : 0.0;
            for (int k = 0; k < 3; k++)
                sum += a[row * 4 + k] * b[k * 4 + column];
            out[row * 4 + column] = sum;
        }
    }
}

static void multiply_rotations(const double *a, const double *b, double *out)
{
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            out[row * 3 + column] = a[row * 3] * b[column] + a[row * 3 + 1] * b[3 + column] +
                                    a[row * 3 + 2] * b[6 + column];
    }
}

void compose_transform(const double *translation, const double *quaternion, const double *scale,
                       const std::string &owner, double *out, double *rotation)
{
    const double length = std::sqrt(quaternion[0] * quaternion[0] + quaternion[1] * quaternion[1] +
                                    quaternion[2] * quaternion[2] + quaternion[3] * quaternion[3]);
    if (!(length > 1e-12) || !std::isfinite(length))
        fail_import(STATUS_FORMAT, "%s: its rotation is no unit quaternion", owner.c_str());
    const double x = quaternion[0] / length;
    const double y = quaternion[1] / length;
    const double z = quaternion[2] / length;
    const double w = quaternion[3] / length;
    const double turn[9] = {
        1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - z * w),       2.0 * (x * z + y * w),
        2.0 * (x * y + z * w),       1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - x * w),
        2.0 * (x * z - y * w),       2.0 * (y * z + x * w),       1.0 - 2.0 * (x * x + y * y)};
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            out[row * 4 + column] = turn[row * 3 + column] * scale[column];
        out[row * 4 + 3] = translation[row];
    }
    if (rotation != nullptr)
        memcpy(rotation, turn, sizeof(turn));
}

// Scales a vector to unit length; false if it has none.
static bool normalize3(double *vector)
{
    const double length =
        std::sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2]);
    if (!(length > 0.0) || !std::isfinite(length))
        return false;
    for (int i = 0; i < 3; i++)
        vector[i] /= length;
    return true;
}

// The rotation of a matrix: its Z axis is kept, its Y axis made perpendicular to that, and X
// follows. The identity if the matrix is flat.
static void extract_rotation(const double *matrix, double *rotation)
{
    double y[3] = {matrix[1], matrix[5], matrix[9]};
    double z[3] = {matrix[2], matrix[6], matrix[10]};
    const bool has_z = normalize3(z);
    const double along = y[0] * z[0] + y[1] * z[1] + y[2] * z[2];
    for (int i = 0; i < 3; i++)
        y[i] -= along * z[i];
    const bool has_y = normalize3(y);
    const double x[3] = {y[1] * z[2] - y[2] * z[1], y[2] * z[0] - y[0] * z[2],
                         y[0] * z[1] - y[1] * z[0]};
    for (int i = 0; i < 3; i++) {
        rotation[i * 3] = has_y && has_z ? x[i] : (i == 0 ? 1.0 : 0.0);
        rotation[i * 3 + 1] = has_y && has_z ? y[i] : (i == 1 ? 1.0 : 0.0);
        rotation[i * 3 + 2] = has_y && has_z ? z[i] : (i == 2 ? 1.0 : 0.0);
    }
}

// Copies an array of the file if it is there and has the right length.
static void read_array(const std::vector<double> &from, size_t count, const std::string &owner,
                       const char *name, double *out)
{
    if (from.empty())
        return;
    if (from.size() != count)
        fail_import(STATUS_FORMAT, "%s: %s has %zu numbers, not %zu", owner.c_str(), name,
                    from.size(), count);
    for (size_t i = 0; i < count; i++)
        out[i] = finite_float(from[i], owner, name) == 0.0f ? 0.0 : from[i];
}

// A node's own transform.
static void local_transform(const tinygltf::Node &node, const std::string &owner, double *matrix,
                            double *rotation)
{
    if (node.matrix.empty()) {
        double translation[3] = {0.0, 0.0, 0.0};
        double quaternion[4] = {0.0, 0.0, 0.0, 1.0};
        double scale[3] = {1.0, 1.0, 1.0};
        read_array(node.translation, 3, owner, "translation", translation);
        read_array(node.rotation, 4, owner, "rotation", quaternion);
        read_array(node.scale, 3, owner, "scale", scale);
        compose_transform(translation, quaternion, scale, owner, matrix, rotation);
        return;
    }
    double columns[16];
    read_array(node.matrix, 16, owner, "matrix", columns);
    for (int i = 0; i < 4; i++) {
        if (std::fabs(columns[i * 4 + 3] - (i == 3 ? 1.0 : 0.0)) > LAST_ROW_TOLERANCE)
            fail_import(STATUS_FORMAT, "%s: the last row of its matrix is not 0, 0, 0, 1",
                        owner.c_str());
    }
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 4; column++)
            matrix[row * 4 + column] = columns[column * 4 + row];
    }
    extract_rotation(matrix, rotation);
}

static std::string node_label(const import_context &context, size_t index)
{
    return label("node", index, context.model.nodes[index].name);
}

// The parent of each node, or -1; fails where one has two.
static std::vector<int> find_parents(const import_context &context)
{
    const std::vector<tinygltf::Node> &nodes = context.model.nodes;
    std::vector<int> parents(nodes.size(), -1);
    for (size_t i = 0; i < nodes.size(); i++) {
        for (const int child : nodes[i].children) {
            if (child < 0 || static_cast<size_t>(child) >= nodes.size())
                fail_import(STATUS_FORMAT, "%s: there is no node %d to be its child",
                            node_label(context, i).c_str(), child);
            const size_t index = static_cast<size_t>(child);
            if (parents[index] >= 0)
                fail_import(STATUS_FORMAT, "%s has two parents: nodes %d and %zu",
                            node_label(context, index).c_str(), parents[index], i);
            parents[index] = static_cast<int>(i);
        }
    }
    return parents;
}

// Is the node itself shown (KHR_node_visibility)?
static bool is_shown(const tinygltf::Node &node)
{
    const tinygltf::Value *extension = find_extension(node.extensions, "KHR_node_visibility");
    if (extension == nullptr || !extension->Has("visible"))
        return true;
    const tinygltf::Value &visible = extension->Get(std::string("visible"));
    return !visible.IsBool() || visible.Get<bool>();
}

// All nodes below these roots, parents before their children.
static std::vector<int> descend(const import_context &context, const std::vector<int> &roots)
{
    std::vector<int> order = roots;
    for (size_t i = 0; i < order.size(); i++) {
        const tinygltf::Node &node = context.model.nodes[static_cast<size_t>(order[i])];
        order.insert(order.end(), node.children.begin(), node.children.end());
    }
    return order;
}

static std::vector<int> find_roots(const std::vector<int> &parents)
{
    std::vector<int> roots;
    for (size_t i = 0; i < parents.size(); i++) {
        if (parents[i] < 0)
            roots.push_back(static_cast<int>(i));
    }
    return roots;
}

void place_nodes(import_context &context)
{
    const std::vector<tinygltf::Node> &nodes = context.model.nodes;
    const std::vector<int> parents = find_parents(context);
    const std::vector<int> order = descend(context, find_roots(parents));

    // With one parent each, nodes that no root reaches go round in a circle.
    if (order.size() != nodes.size()) {
        std::vector<bool> is_reached(nodes.size());
        for (const int index : order)
            is_reached[static_cast<size_t>(index)] = true;
        for (size_t i = 0; i < nodes.size(); i++) {
            if (!is_reached[i])
                fail_import(STATUS_FORMAT, "%s is its own ancestor",
                            node_label(context, i).c_str());
        }
    }

    context.poses.resize(nodes.size());
    for (const int index : order) {
        const size_t i = static_cast<size_t>(index);
        node_pose &pose = context.poses[i];
        const std::string owner = node_label(context, i);
        double matrix[12];
        double rotation[9];
        local_transform(nodes[i], owner, matrix, rotation);
        pose.is_visible = is_shown(nodes[i]);
        if (parents[i] >= 0) {
            const node_pose &parent = context.poses[static_cast<size_t>(parents[i])];
            multiply_transforms(parent.to_world, matrix, pose.to_world);
            multiply_rotations(parent.rotation, rotation, pose.rotation);
            pose.is_visible = pose.is_visible && parent.is_visible;
        } else {
            memcpy(pose.to_world, matrix, sizeof(matrix));
            memcpy(pose.rotation, rotation, sizeof(rotation));
        }
        for (const double value : pose.to_world)
            finite_float(value, owner, "its place in the world");
    }
}

std::vector<int> scene_nodes(import_context &context)
{
    const tinygltf::Model &model = context.model;
    const std::vector<int> parents = find_parents(context);
    if (model.scenes.empty()) {
        if (model.defaultScene > 0)
            fail_import(STATUS_FORMAT, "there is no scene %d", model.defaultScene);
        warn_once(context, "scene", "it has no scene; all its nodes are shown");
        return descend(context, find_roots(parents));
    }
    if (model.defaultScene >= static_cast<int>(model.scenes.size()) || model.defaultScene < -1)
        fail_import(STATUS_FORMAT, "there is no scene %d", model.defaultScene);
    const size_t chosen = model.defaultScene < 0 ? 0 : static_cast<size_t>(model.defaultScene);
    const tinygltf::Scene &scene = model.scenes[chosen];
    const std::string owner = label("scene", chosen, scene.name);
    std::vector<bool> is_listed(model.nodes.size());
    for (const int root : scene.nodes) {
        if (root < 0 || static_cast<size_t>(root) >= model.nodes.size())
            fail_import(STATUS_FORMAT, "%s: there is no node %d", owner.c_str(), root);
        const size_t index = static_cast<size_t>(root);
        if (parents[index] >= 0)
            fail_import(STATUS_FORMAT, "%s: %s is no root: node %d is its parent", owner.c_str(),
                        node_label(context, index).c_str(), parents[index]);
        if (is_listed[index])
            fail_import(STATUS_FORMAT, "%s lists %s twice", owner.c_str(),
                        node_label(context, index).c_str());
        is_listed[index] = true;
    }
    return descend(context, scene.nodes);
}
