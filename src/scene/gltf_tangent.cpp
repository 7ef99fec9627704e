#include "scene/gltf_tangent.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

static const uint32_t NO_VERTEX = UINT32_MAX;

struct vector3 {
    double x, y, z;
};

static vector3 load(const float *v)
{
    return {v[0], v[1], v[2]};
}

static vector3 subtract(vector3 a, vector3 b)
{
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}

static vector3 scale(vector3 a, double s)
{
    return {a.x * s, a.y * s, a.z * s};
}

static double dot(vector3 a, vector3 b)
{
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// A unit vector; 0 stays 0.
static vector3 normalize(vector3 a)
{
    const double length = std::sqrt(dot(a, a));
    return length > 0.0 ? scale(a, 1.0 / length) : vector3{0.0, 0.0, 0.0};
}

// What of a lies in the plane of a unit normal, as a unit vector.
static vector3 project(vector3 a, vector3 normal)
{
    return normalize(subtract(a, scale(normal, dot(a, normal))));
}

// Some unit vector at a right angle to a unit normal.
static vector3 any_tangent(vector3 normal)
{
    const bool along_x = std::fabs(normal.x) > 0.9;
    return project({along_x ? 0.0 : 1.0, along_x ? 1.0 : 0.0, 0.0}, normal);
}

static void store(float *out, vector3 tangent, double handedness)
{
    out[0] = static_cast<float>(tangent.x);
    out[1] = static_cast<float>(tangent.y);
    out[2] = static_cast<float>(tangent.z);
    out[3] = handedness < 0.0 ? -1.0f : 1.0f;
}

// A triangle as texture coordinates see it.
struct uv_triangle {
    vector3 tangent; // unit, where u grows; 0 if they enclose no area
    int mirrored;    // 1 if they run the other way round than the corners
};

static uv_triangle measure(const shape &shape, const float *uv, const uint32_t *corner)
{
    const vector3 p0 = load(shape.positions + corner[0] * (size_t)3);
    const vector3 d1 = subtract(load(shape.positions + corner[1] * (size_t)3), p0);
    const vector3 d2 = subtract(load(shape.positions + corner[2] * (size_t)3), p0);
    const float *const at0 = uv + corner[0] * (size_t)2;
    const float *const at1 = uv + corner[1] * (size_t)2;
    const float *const at2 = uv + corner[2] * (size_t)2;
    const double u1 = static_cast<double>(at1[0]) - at0[0];
    const double v1 = static_cast<double>(at1[1]) - at0[1];
    const double u2 = static_cast<double>(at2[0]) - at0[0];
    const double v2 = static_cast<double>(at2[1]) - at0[1];
    const double area = u1 * v2 - u2 * v1;
    uv_triangle out = {{0.0, 0.0, 0.0}, area < 0.0 ? 1 : 0};
    if (area != 0.0)
        out.tangent =
            scale(normalize(subtract(scale(d1, v2), scale(d2, v1))), area < 0.0 ? -1.0 : 1.0);
    return out;
}

// The angle of a triangle at one corner, as seen along the normal there.
static double corner_angle(const shape &shape, const uint32_t *corner, size_t which, vector3 normal)
{
    const vector3 p = load(shape.positions + corner[which] * (size_t)3);
    const vector3 a = load(shape.positions + corner[(which + 1) % 3] * (size_t)3);
    const vector3 b = load(shape.positions + corner[(which + 2) % 3] * (size_t)3);
    const double cosine = dot(project(subtract(a, p), normal), project(subtract(b, p), normal));
    return std::acos(std::min(std::max(cosine, -1.0), 1.0));
}

// Numbers vertices so that those of one position, normal and texture coordinate have one number.
static std::vector<uint32_t> weld(const shape &shape, const float *uv)
{
    const auto compare = [&](uint32_t a, uint32_t b) {
        int order = memcmp(shape.positions + a * (size_t)3, shape.positions + b * (size_t)3,
                           3 * sizeof(float));
        if (order == 0)
            order = memcmp(shape.normals + a * (size_t)3, shape.normals + b * (size_t)3,
                           3 * sizeof(float));
        if (order == 0)
            order = memcmp(uv + a * (size_t)2, uv + b * (size_t)2, 2 * sizeof(float));
        return order;
    };
    std::vector<uint32_t> sorted(shape.vertex_count);
    for (size_t i = 0; i < sorted.size(); i++)
        sorted[i] = static_cast<uint32_t>(i);
    std::sort(sorted.begin(), sorted.end(),
              [&](uint32_t a, uint32_t b) { return compare(a, b) < 0; });
    std::vector<uint32_t> number(shape.vertex_count);
    for (size_t i = 0; i < sorted.size(); i++)
        number[sorted[i]] =
            i > 0 && compare(sorted[i - 1], sorted[i]) == 0 ? number[sorted[i - 1]] : sorted[i];
    return number;
}

// Copies the attributes of some vertices behind those of all.
static float *append(import_context &context, const float *values, size_t components, size_t count,
                     const std::vector<uint32_t> &more)
{
    if (values == nullptr)
        return nullptr;
    float *const all = arena_array<float>(context, (count + more.size()) * components);
    memcpy(all, values, count * components * sizeof(float));
    for (size_t i = 0; i < more.size(); i++)
        memcpy(all + (count + i) * components, values + more[i] * components,
               components * sizeof(float));
    return all;
}

static void append_vertices(import_context &context, shape &shape,
                            const std::vector<uint32_t> &more)
{
    const size_t count = shape.vertex_count;
    shape.positions = append(context, shape.positions, 3, count, more);
    shape.normals = append(context, shape.normals, 3, count, more);
    shape.uv0 = append(context, shape.uv0, 2, count, more);
    shape.uv1 = append(context, shape.uv1, 2, count, more);
    shape.colors = append(context, shape.colors, 4, count, more);
    shape.vertex_count += more.size();
}

// Sums of one welded vertex, for triangles of either handedness.
struct tangent_sums {
    vector3 of[2];
};

static std::vector<tangent_sums> sum_tangents(const shape &shape, const std::vector<uint32_t> &list,
                                              const std::vector<uv_triangle> &triangles,
                                              const std::vector<uint32_t> &welded)
{
    std::vector<tangent_sums> sums(shape.vertex_count);
    for (size_t i = 0; i < list.size(); i++) {
        const uv_triangle &triangle = triangles[i / 3];
        const uint32_t *const corner = &list[i / 3 * 3];
        const vector3 normal = load(shape.normals + list[i] * (size_t)3);
        const vector3 tangent =
            scale(project(triangle.tangent, normal), corner_angle(shape, corner, i % 3, normal));
        vector3 &sum = sums[welded[list[i]]].of[triangle.mirrored];
        sum = {sum.x + tangent.x, sum.y + tangent.y, sum.z + tangent.z};
    }
    return sums;
}

void make_tangents(import_context &context, shape &shape, const float *uv,
                   std::vector<uint32_t> &list)
{
    const size_t count = shape.vertex_count;
    if (uv == nullptr) {
        shape.tangents = arena_array<float>(context, count * 4);
        repair_tangents(shape);
        return;
    }
    std::vector<uv_triangle> triangles(list.size() / 3);
    for (size_t t = 0; t < triangles.size(); t++)
        triangles[t] = measure(shape, uv, &list[t * 3]);
    const std::vector<uint32_t> welded = weld(shape, uv);
    const std::vector<tangent_sums> sums = sum_tangents(shape, list, triangles, welded);

    // Give each vertex the handedness of its first triangle, and the others a copy of it.
    std::vector<uint32_t> more;                     // what the copies are copies of
    std::vector<uint32_t> copies(count, NO_VERTEX); // of each vertex
    std::vector<int8_t> mirrored(count, -1);        // -1: not known yet
    for (size_t i = 0; i < list.size(); i++) {
        const uint32_t vertex = list[i];
        const uv_triangle &triangle = triangles[i / 3];
        if (dot(triangle.tangent, triangle.tangent) == 0.0)
            continue;
        if (mirrored[vertex] < 0)
            mirrored[vertex] = static_cast<int8_t>(triangle.mirrored);
        if (mirrored[vertex] == triangle.mirrored)
            continue;
        if (copies[vertex] == NO_VERTEX) {
            copies[vertex] = static_cast<uint32_t>(count + more.size());
            more.push_back(vertex);
        }
        list[i] = copies[vertex];
    }
    if (!more.empty())
        append_vertices(context, shape, more);

    // glTF's v runs downwards, so that what is not mirrored has the bitangent N x T turned round.
    shape.tangents = arena_array<float>(context, shape.vertex_count * 4);
    for (size_t v = 0; v < shape.vertex_count; v++) {
        const uint32_t from = v < count ? static_cast<uint32_t>(v) : more[v - count];
        const int side = (mirrored[from] == 1) != (v >= count) ? 1 : 0;
        store(shape.tangents + v * 4, sums[welded[from]].of[side], side == 1 ? 1.0 : -1.0);
    }
    repair_tangents(shape);
}

void repair_tangents(shape &shape)
{
    for (size_t v = 0; v < shape.vertex_count; v++) {
        float *const tangent = shape.tangents + v * 4;
        const vector3 normal = load(shape.normals + v * 3);
        const vector3 projected = project(load(tangent), normal);
        const bool is_there = dot(projected, projected) > 0.5;
        store(tangent, is_there ? projected : any_tangent(normal), tangent[3]);
    }
}
