#include "scene/gltf_shape.hpp"

#include <cmath>

#include "scene/gltf_accessor.hpp"

void face_normal(const float *a, const float *b, const float *c, float *out)
{
    double u[3];
    double v[3];
    for (int i = 0; i < 3; i++) {
        u[i] = static_cast<double>(b[i]) - a[i];
        v[i] = static_cast<double>(c[i]) - a[i];
    }
    const double n[3] = {u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2],
                         u[0] * v[1] - u[1] * v[0]};
    const double length = std::sqrt(n[0] * n[0] + n[1] * n[1] + n[2] * n[2]);
    for (int i = 0; i < 3; i++)
        out[i] = length > 0.0 ? static_cast<float>(n[i] / length) : (i == 2 ? 1.0f : 0.0f);
}

// Gives each vertex without a normal the sum of the unit normals of its triangles.
static void fill_normals(shape &shape, const std::vector<bool> &is_missing, const uint32_t *indices,
                         size_t triangle_count)
{
    for (size_t t = 0; t < triangle_count; t++) {
        float normal[3];
        face_normal(shape.positions + indices[t * 3] * (size_t)3,
                    shape.positions + indices[t * 3 + 1] * (size_t)3,
                    shape.positions + indices[t * 3 + 2] * (size_t)3, normal);
        for (size_t corner = 0; corner < 3; corner++) {
            const size_t vertex = indices[t * 3 + corner];
            for (size_t c = 0; c < 3 && is_missing[vertex]; c++)
                shape.normals[vertex * 3 + c] += normal[c];
        }
    }
}

// Scales a vector to unit length; false, and left as it is, if it has none.
static bool normalize3(float *vector)
{
    const double x = vector[0];
    const double y = vector[1];
    const double z = vector[2];
    const double length = std::sqrt(x * x + y * y + z * z);
    if (!(length > 1e-20))
        return false;
    vector[0] = static_cast<float>(x / length);
    vector[1] = static_cast<float>(y / length);
    vector[2] = static_cast<float>(z / length);
    return true;
}

void normalize_normals(import_context &context, const std::string &owner, shape &shape,
                       const uint32_t *indices, size_t triangle_count)
{
    size_t missing_count = 0;
    std::vector<bool> is_missing;
    for (size_t v = 0; v < shape.vertex_count; v++) {
        if (normalize3(shape.normals + v * 3))
            continue;
        if (missing_count++ == 0)
            is_missing.resize(shape.vertex_count);
        is_missing[v] = true;
        shape.normals[v * 3] = shape.normals[v * 3 + 1] = shape.normals[v * 3 + 2] = 0.0f;
    }
    if (missing_count == 0)
        return;
    warn_once(context, "normals", "%s: %zu normals have no length; normals of the faces are used",
              owner.c_str(), missing_count);
    fill_normals(shape, is_missing, indices, triangle_count);
    for (size_t v = 0; v < shape.vertex_count; v++) {
        if (is_missing[v] && !normalize3(shape.normals + v * 3))
            shape.normals[v * 3 + 2] = 1.0f;
    }
}

// Adds one attribute of a morph target. `limit` is the number of components that the shape has.
static void add_target(import_context &context, int accessor, double weight, size_t vertex_count,
                       int target_components, int components, const std::string &owner, float *out)
{
    if (checked_count(context, accessor, target_components, owner) != vertex_count)
        fail_import(STATUS_FORMAT, "%s: a morph target has another number of vertices",
                    owner.c_str());
    std::vector<float> deltas(vertex_count * static_cast<size_t>(target_components));
    read_floats(context, accessor, target_components, false, owner, deltas.data());
    for (size_t v = 0; v < vertex_count; v++) {
        for (int c = 0; c < target_components && c < components; c++) {
            const size_t to = v * static_cast<size_t>(components) + static_cast<size_t>(c);
            const size_t from = v * static_cast<size_t>(target_components) + static_cast<size_t>(c);
            out[to] += static_cast<float>(weight * deltas[from]);
        }
    }
}

void apply_morph(import_context &context, const tinygltf::Primitive &primitive,
                 const std::vector<double> &weights, const std::string &owner, shape &shape)
{
    const struct {
        const char *name;
        float *values;
        int components;
    } attributes[] = {{"POSITION", shape.positions, 3}, {"NORMAL", shape.normals, 3},
                      {"TANGENT", shape.tangents, 4},   {"TEXCOORD_0", shape.uv0, 2},
                      {"TEXCOORD_1", shape.uv1, 2},     {"COLOR_0", shape.colors, 4}};
    for (size_t t = 0; t < primitive.targets.size() && t < weights.size(); t++) {
        const std::string name = owner + ", target " + std::to_string(t);
        const double weight = finite_float(weights[t], name, "weight");
        if (weight == 0.0)
            continue;
        for (const auto &attribute : attributes) {
            const auto found = primitive.targets[t].find(attribute.name);
            if (found == primitive.targets[t].end() || attribute.values == nullptr)
                continue;
            const int components = component_count(find_accessor(context, found->second, name));
            if (components != attribute.components &&
                !(attribute.components == 4 && components == 3))
                fail_import(STATUS_FORMAT, "%s: %s has %d components", name.c_str(), attribute.name,
                            components);
            add_target(context, found->second, weight, shape.vertex_count, components,
                       attribute.components, name, attribute.values);
        }
    }
}

// The matrices that take a vertex from its mesh to the world, one for each joint: 3x4, row major.
static std::vector<double> joint_matrices(import_context &context, int skin_index,
                                          const std::string &owner)
{
    if (static_cast<size_t>(skin_index) >= context.model.skins.size())
        fail_import(STATUS_FORMAT, "%s: there is no skin %d", owner.c_str(), skin_index);
    const tinygltf::Skin &skin = context.model.skins[static_cast<size_t>(skin_index)];
    const std::string name =
        owner + ", " + label("skin", static_cast<size_t>(skin_index), skin.name);
    const size_t count = skin.joints.size();
    std::vector<float> inverse_bind;
    if (skin.inverseBindMatrices >= 0) {
        const size_t available = checked_count(context, skin.inverseBindMatrices, 16, name);
        if (available < count)
            fail_import(STATUS_FORMAT, "%s: %zu joints, but %zu inverse bind matrices",
                        name.c_str(), count, available);
        inverse_bind.resize(available * 16);
        read_floats(context, skin.inverseBindMatrices, 16, false, name, inverse_bind.data());
    }

    std::vector<double> matrices(count * 12);
    for (size_t j = 0; j < count; j++) {
        const int joint = skin.joints[j];
        if (joint < 0 || static_cast<size_t>(joint) >= context.poses.size())
            fail_import(STATUS_FORMAT, "%s: there is no node %d", name.c_str(), joint);
        const double *world = context.poses[static_cast<size_t>(joint)].to_world;
        for (size_t row = 0; row < 3; row++) {
            for (size_t column = 0; column < 4; column++) {
                // glTF stores matrices by columns.
                double sum = column == 3 && inverse_bind.empty() ? world[row * 4 + 3] : 0.0;
                for (size_t k = 0; k < 3; k++)
                    sum += world[row * 4 + k] * (inverse_bind.empty()
                                                     ? (k == column ? 1.0 : 0.0)
                                                     : inverse_bind[j * 16 + column * 4 + k]);
                if (column == 3 && !inverse_bind.empty())
                    sum += world[row * 4 + 3];
                matrices[j * 12 + row * 4 + column] = sum;
            }
        }
    }
    return matrices;
}

// JOINTS_n and WEIGHTS_n of a primitive, all sets side by side.
struct influences {
    size_t set_count = 0;
    std::vector<uint32_t> joints[2]; // [vertex_count * 4]
    std::vector<float> weights[2];   // [vertex_count * 4]
};

static influences read_influences(import_context &context, const tinygltf::Primitive &primitive,
                                  size_t vertex_count, const std::string &owner)
{
    influences read;
    for (; read.set_count < 2; read.set_count++) {
        const std::string number = std::to_string(read.set_count);
        const auto joints = primitive.attributes.find("JOINTS_" + number);
        const auto weights = primitive.attributes.find("WEIGHTS_" + number);
        if (joints == primitive.attributes.end() || weights == primitive.attributes.end())
            break;
        const std::string joints_name = owner + ": JOINTS_" + number;
        const std::string weights_name = owner + ": WEIGHTS_" + number;
        if (checked_count(context, joints->second, 4, joints_name) != vertex_count ||
            checked_count(context, weights->second, 4, weights_name) != vertex_count)
            fail_import(STATUS_FORMAT, "%s: joints and weights do not match the vertices",
                        owner.c_str());
        read.joints[read.set_count].resize(vertex_count * 4);
        read.weights[read.set_count].resize(vertex_count * 4);
        read_integers(context, joints->second, 4, joints_name, read.joints[read.set_count].data());
        read_floats(context, weights->second, 4, true, weights_name,
                    read.weights[read.set_count].data());
    }
    return read;
}

// Blends the matrices of one vertex; false if all its weights are 0.
static bool blend_matrix(const influences &influences, const std::vector<double> &matrices,
                         size_t vertex, const std::string &owner, double *out)
{
    double weight_sum = 0.0;
    for (int i = 0; i < 12; i++)
        out[i] = 0.0;
    for (size_t set = 0; set < influences.set_count; set++) {
        for (size_t k = 0; k < 4; k++) {
            const double weight = influences.weights[set][vertex * 4 + k];
            const size_t joint = influences.joints[set][vertex * 4 + k];
            if (weight == 0.0)
                continue;
            if (joint >= matrices.size() / 12)
                fail_import(STATUS_FORMAT, "%s: vertex %zu follows joint %zu, which does not exist",
                            owner.c_str(), vertex, joint);
            for (size_t i = 0; i < 12; i++)
                out[i] += weight * matrices[joint * 12 + i];
            weight_sum += weight;
        }
    }
    for (int i = 0; i < 12 && weight_sum > 0.0; i++)
        out[i] /= weight_sum;
    return weight_sum > 0.0;
}

// Turns a normal by the cofactors of m, which also serve where m cannot be inverted.
static void turn_normal(const double *m, float *normal)
{
    const double n[3] = {normal[0], normal[1], normal[2]};
    for (int row = 0; row < 3; row++) {
        const double *a = m + (row + 1) % 3 * 4;
        const double *b = m + (row + 2) % 3 * 4;
        normal[row] = static_cast<float>((a[1] * b[2] - a[2] * b[1]) * n[0] +
                                         (a[2] * b[0] - a[0] * b[2]) * n[1] +
                                         (a[0] * b[1] - a[1] * b[0]) * n[2]);
    }
}

// Turns a tangent as edges turn.
static void turn_tangent(const double *m, float *tangent)
{
    const double t[3] = {tangent[0], tangent[1], tangent[2]};
    for (int row = 0; row < 3; row++)
        tangent[row] =
            static_cast<float>(m[row * 4] * t[0] + m[row * 4 + 1] * t[1] + m[row * 4 + 2] * t[2]);
}

bool apply_skin(import_context &context, const tinygltf::Primitive &primitive, int skin_index,
                const std::string &owner, shape &shape)
{
    const std::vector<double> matrices = joint_matrices(context, skin_index, owner);
    const influences influences = read_influences(context, primitive, shape.vertex_count, owner);
    if (influences.set_count == 0)
        return false;
    for (size_t v = 0; v < shape.vertex_count; v++) {
        double m[12];
        if (!blend_matrix(influences, matrices, v, owner, m))
            continue;
        float *const position = shape.positions + v * 3;
        const double p[3] = {position[0], position[1], position[2]};
        for (size_t row = 0; row < 3; row++) {
            const double *r = m + row * 4;
            position[row] = finite_float(r[0] * p[0] + r[1] * p[1] + r[2] * p[2] + r[3], owner,
                                         "a skinned position");
        }
        if (shape.normals != nullptr)
            turn_normal(m, shape.normals + v * 3);
        if (shape.tangents != nullptr)
            turn_tangent(m, shape.tangents + v * 4);
    }
    return true;
}
