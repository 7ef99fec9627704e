#include "scene/gltf_environment.hpp"

#include <algorithm>
#include <cmath>

#include "scene/gltf_image.hpp"
#include "scene/gltf_node.hpp"

static const double PI = 3.14159265358979323846;
static const size_t FACES = 6;
static const int MAX_WIDTH = 8192; // columns of the lat-long image
static const int TAPS = 3;         // samples of the cube for a texel of it, along either side

// One face: linear RGB, rows from the top.
using face = std::vector<float>;

struct cube {
    face faces[FACES];
    int size = 0; // texels on a side of each
};

// The linear value of an 8-bit sRGB one.
static double from_srgb(uint8_t byte)
{
    const double x = byte / 255.0;
    return x <= 0.04045 ? x / 12.92 : std::pow((x + 0.055) / 1.055, 2.4);
}

static cube read_cube(import_context &context, const tinygltf::Value &light,
                      const std::string &owner)
{
    const tinygltf::Value none;
    const tinygltf::Value &levels =
        light.Has("specularImages") ? light.Get(std::string("specularImages")) : none;
    const tinygltf::Value &level = levels.IsArray() && levels.ArrayLen() > 0 ? levels.Get(0) : none;
    if (!level.IsArray() || level.ArrayLen() != FACES)
        fail_import(STATUS_FORMAT, "%s: specularImages holds no list of six images", owner.c_str());

    cube out;
    for (size_t i = 0; i < FACES; i++) {
        const tinygltf::Value &index = level.Get(static_cast<int>(i));
        if (!index.IsInt())
            fail_import(STATUS_FORMAT, "%s: specularImages names no image", owner.c_str());
        const decoded_image image = decode_image(context, index.Get<int>(), owner);
        const int size = static_cast<int>(image.width);
        if (image.width != image.height || (i > 0 && size != out.size))
            fail_import(STATUS_FORMAT,
                        "%s: image %d has %u x %u texels; the faces of a cube are equal squares",
                        owner.c_str(), index.Get<int>(), image.width, image.height);
        out.size = size;
        out.faces[i].resize(static_cast<size_t>(size) * image.height * 3);
        for (size_t texel = 0; texel < out.faces[i].size() / 3; texel++) {
            const uint8_t *rgba = image.rgba.get() + texel * 4;
            const double divisor = std::max<int>(rgba[3], 1) / 255.0;
            for (size_t k = 0; k < 3; k++)
                out.faces[i][texel * 3 + k] = static_cast<float>(from_srgb(rgba[k]) / divisor);
        }
    }
    return out;
}

// Adds what a face shows at a place, -1 .. 1 to the right and down: bilinear, ends at its rim.
static void add_place(const cube &cube, size_t face_index, double right, double down, double *rgb)
{
    const double last = cube.size - 1;
    const double x = std::min(std::max((right + 1.0) * 0.5 * cube.size - 0.5, 0.0), last);
    const double y = std::min(std::max((down + 1.0) * 0.5 * cube.size - 0.5, 0.0), last);
    const size_t x0 = static_cast<size_t>(x);
    const size_t y0 = static_cast<size_t>(y);
    const size_t size = static_cast<size_t>(cube.size);
    const size_t x1 = std::min(x0 + 1, size - 1);
    const size_t y1 = std::min(y0 + 1, size - 1);
    const double across = x - static_cast<double>(x0);
    const double below = y - static_cast<double>(y0);
    const face &texels = cube.faces[face_index];
    for (size_t k = 0; k < 3; k++) {
        const double top = texels[(y0 * size + x0) * 3 + k] * (1.0 - across) +
                           texels[(y0 * size + x1) * 3 + k] * across;
        const double bottom = texels[(y1 * size + x0) * 3 + k] * (1.0 - across) +
                              texels[(y1 * size + x1) * 3 + k] * across;
        rgb[k] += top * (1.0 - below) + bottom * below;
    }
}

// Adds what the cube shows in a direction.
static void add_direction(const cube &cube, const double *d, double *rgb)
{
    const double x = std::fabs(d[0]);
    const double y = std::fabs(d[1]);
    const double z = std::fabs(d[2]);
    if (x >= y && x >= z)
        add_place(cube, d[0] > 0.0 ? 0 : 1, (d[0] > 0.0 ? d[2] : -d[2]) / x, -d[1] / x, rgb);
    else if (y >= z)
        add_place(cube, d[1] > 0.0 ? 2 : 3, -d[0] / y, (d[1] > 0.0 ? d[2] : -d[2]) / y, rgb);
    else
        add_place(cube, d[2] > 0.0 ? 4 : 5, (d[2] > 0.0 ? -d[0] : d[0]) / z, -d[1] / z, rgb);
}

// Resamples a cube, turned, into a lat-long image as shared/environment.h has it.
static void resample(import_context &context, const cube &cube, const double *rotation,
                     double intensity)
{
    scene_environment &out = context.scene->environment;
    out.width = static_cast<uint32_t>(std::min(4 * cube.size, MAX_WIDTH));
    out.height = (out.width + 1) / 2;
    out.rgb = arena_array<float>(context, static_cast<size_t>(out.width) * out.height * 3);
    const long width = out.width;
    const long height = out.height;
#pragma omp parallel for schedule(static)
    for (long row = 0; row < height; row++) {
        for (long column = 0; column < width; column++) {
            double sum[3] = {0.0, 0.0, 0.0};
            for (int tap = 0; tap < TAPS * TAPS; tap++) {
                const double down = (row + (tap / TAPS + 0.5) / TAPS) / height * PI;
                const double turn = (column + (tap % TAPS + 0.5) / TAPS) / width * 2.0 * PI - PI;
                const double world[3] = {std::sin(down) * std::sin(turn), std::cos(down),
                                         -std::sin(down) * std::cos(turn)};
                double local[3]; // the rotation undone
                for (int k = 0; k < 3; k++)
                    local[k] = rotation[k] * world[0] + rotation[3 + k] * world[1] +
                               rotation[6 + k] * world[2];
                add_direction(cube, local, sum);
            }
            float *texel = out.rgb + (row * width + column) * 3;
            for (int k = 0; k < 3; k++)
                texel[k] = static_cast<float>(sum[k] * intensity / (TAPS * TAPS));
        }
    }
}

void load_environment(import_context &context)
{
    const tinygltf::Model &model = context.model;
    if (model.scenes.empty())
        return;
    const size_t shown = model.defaultScene < 0 ? 0 : static_cast<size_t>(model.defaultScene);
    const std::string scene_owner = label("scene", shown, model.scenes[shown].name);
    const char *const name = "EXT_lights_image_based";
    const tinygltf::Value *use = find_extension(model.scenes[shown].extensions, name);
    const int index = use != nullptr ? index_member(*use, "light", scene_owner) : -1;
    if (index < 0)
        return;
    const tinygltf::Value *root = find_extension(model.extensions, name);
    const tinygltf::Value none;
    const tinygltf::Value &lights =
        root != nullptr && root->Has("lights") ? root->Get(std::string("lights")) : none;
    if (!lights.IsArray() || static_cast<size_t>(index) >= lights.ArrayLen())
        fail_import(STATUS_FORMAT, "%s: there is no image-based light %d", scene_owner.c_str(),
                    index);

    const tinygltf::Value &light = lights.Get(index);
    const std::string owner = label("image-based light", static_cast<size_t>(index), "");
    const double intensity = number_member(light, "intensity", 1.0, owner);
    if (!(intensity >= 0.0) || !std::isfinite(intensity))
        fail_import(STATUS_FORMAT, "%s: an intensity of %g is none", owner.c_str(), intensity);
    float quaternion[4] = {0.0f, 0.0f, 0.0f, 1.0f};
    numbers_member(light, "rotation", quaternion, 4, owner);
    const double origin[3] = {0.0, 0.0, 0.0};
    const double unit[3] = {1.0, 1.0, 1.0};
    const double turned[4] = {quaternion[0], quaternion[1], quaternion[2], quaternion[3]};
    double transform[12];
    double rotation[9];
    compose_transform(origin, turned, unit, owner, transform, rotation);
    resample(context, read_cube(context, light, owner), rotation, intensity);
}
