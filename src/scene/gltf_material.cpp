#include "scene/gltf_material.hpp"

#include <cmath>

#include "scene/gltf_image.hpp"

// A texture as a material names it, from a core property or from an extension's.
struct texture_reference {
    int index = -1; // -1: none
    int texcoord = 0;
    const tinygltf::Value *transform = nullptr; // KHR_texture_transform, or none
};

uint32_t use_material(import_context &context, int index, const std::string &owner)
{
    const size_t count = context.model.materials.size();
    if (index >= 0 && static_cast<size_t>(index) >= count)
        fail_import(STATUS_FORMAT, "%s: there is no material %d", owner.c_str(), index);
    const size_t used = index < 0 ? count : static_cast<size_t>(index);
    context.material_used[used] = true;
    return static_cast<uint32_t>(used);
}

// A factor that glTF wants within 0 .. 1.
static float unit_factor(import_context &context, double value, const std::string &owner,
                         const char *property)
{
    const float factor = finite_float(value, owner, property);
    if (factor >= 0.0f && factor <= 1.0f)
        return factor;
    warn_once(context, property, "%s: %s %g is not within 0 .. 1 and is clamped", owner.c_str(),
              property, value);
    return factor < 0.0f ? 0.0f : 1.0f;
}

// Refuses a negative factor.
static float positive_factor(double value, const std::string &owner, const char *property)
{
    const float factor = finite_float(value, owner, property);
    if (factor < 0.0f)
        fail_import(STATUS_FORMAT, "%s: %s %g is negative", owner.c_str(), property, value);
    return factor;
}

template <typename INFO> static texture_reference core_texture(const INFO &info)
{
    texture_reference reference;
    reference.index = info.index;
    reference.texcoord = info.texCoord;
    reference.transform = find_extension(info.extensions, "KHR_texture_transform");
    return reference;
}

// A textureInfo that stands within an extension.
static texture_reference extension_texture(const tinygltf::Value &extension, const char *name,
                                           const std::string &owner)
{
    texture_reference reference;
    if (!extension.Has(name))
        return reference;
    const tinygltf::Value &info = extension.Get(std::string(name));
    reference.index = index_member(info, "index", owner);
    if (reference.index < 0)
        fail_import(STATUS_FORMAT, "%s: %s names no texture", owner.c_str(), name);
    if (info.Has("texCoord"))
        reference.texcoord = index_member(info, "texCoord", owner);
    if (info.Has("extensions")) {
        const tinygltf::Value &extensions = info.Get(std::string("extensions"));
        if (extensions.Has("KHR_texture_transform"))
            reference.transform = &extensions.Get(std::string("KHR_texture_transform"));
    }
    return reference;
}

// KHR_texture_transform: translation * rotation * scale, with rotation counter-clockwise as seen
// with v downwards.
static void apply_transform(scene_texture_use &use, const tinygltf::Value &transform,
                            const std::string &owner)
{
    float scale[2] = {1.0f, 1.0f};
    numbers_member(transform, "offset", use.uv_offset, 2, owner);
    numbers_member(transform, "scale", scale, 2, owner);
    const double angle_rad = number_member(transform, "rotation", 0.0, owner);
    const double c = std::cos(angle_rad);
    const double s = std::sin(angle_rad);
    const double matrix[4] = {c * scale[0], s * scale[1], -s * scale[0], c * scale[1]};
    for (int i = 0; i < 4; i++)
        use.uv_matrix[i] = finite_float(matrix[i], owner, "KHR_texture_transform");
}

// The set of texture coordinates that a reference names.
static int texcoord_of(texture_reference reference, const std::string &owner)
{
    const int replaced =
        reference.transform != nullptr ? index_member(*reference.transform, "texCoord", owner) : -1;
    return replaced >= 0 ? replaced : reference.texcoord;
}

static scene_texture_use make_use(import_context &context, texture_collector *collector,
                                  texture_reference reference, const std::string &owner)
{
    scene_texture_use use = {SCENE_NONE, 0, {1.0f, 0.0f, 0.0f, 1.0f}, {0.0f, 0.0f}};
    if (reference.index < 0 || collector == nullptr)
        return use;
    use.texture = use_texture(context, *collector, reference.index, owner);
    int texcoord = texcoord_of(reference, owner);
    if (reference.transform != nullptr)
        apply_transform(use, *reference.transform, owner);
    if (texcoord < 0 || texcoord > 1) {
        warn_once(context, "texcoord",
                  "%s reads TEXCOORD_%d; only 0 and 1 are supported, and 0 is used", owner.c_str(),
                  texcoord);
        texcoord = 0;
    }
    use.texcoord = static_cast<uint32_t>(texcoord);
    return use;
}

// Everything glTF gives a material by default.
static scene_material default_material(import_context &context)
{
    scene_material material = {};
    material.name = arena_text(context, "");
    for (float &factor : material.base_color)
        factor = 1.0f;
    for (float &factor : material.specular_color)
        factor = 1.0f;
    material.metallic = 1.0f;
    material.roughness = 1.0f;
    material.specular_strength = 1.0f;
    material.glossiness = 1.0f;
    material.alpha_cutoff = 0.5f;
    for (float &factor : material.diffuse_transmission_color)
        factor = 1.0f;
    const scene_texture_use none = make_use(context, nullptr, texture_reference(), "");
    material.base_texture = material.surface_texture = material.emissive_texture = none;
    material.specular_texture = material.specular_color_texture = none;
    material.normal_texture = material.transmission_texture = none;
    material.diffuse_transmission_texture = material.diffuse_transmission_color_texture = none;
    material.coat_texture = material.coat_roughness_texture = none;
    material.coat_normal_texture = none;
    material.sheen_color_texture = material.sheen_roughness_texture = none;
    material.normal_scale = material.coat_normal_scale = 1.0f;
    return material;
}

static void read_metallic_roughness(import_context &context, texture_collector *collector,
                                    const tinygltf::PbrMetallicRoughness &source,
                                    const std::string &owner, scene_material &out)
{
    for (size_t i = 0; i < 4; i++)
        out.base_color[i] =
            unit_factor(context, source.baseColorFactor[i], owner, "baseColorFactor");
    out.metallic = unit_factor(context, source.metallicFactor, owner, "metallicFactor");
    out.roughness = unit_factor(context, source.roughnessFactor, owner, "roughnessFactor");
    out.base_texture = make_use(context, collector, core_texture(source.baseColorTexture), owner);
    out.surface_texture =
        make_use(context, collector, core_texture(source.metallicRoughnessTexture), owner);
}

static void read_specular_glossiness(import_context &context, texture_collector *collector,
                                     const tinygltf::Value &source, const std::string &owner,
                                     scene_material &out)
{
    out.specular_glossiness = true;
    for (float &factor : out.base_color)
        factor = 1.0f;
    numbers_member(source, "diffuseFactor", out.base_color, 4, owner);
    numbers_member(source, "specularFactor", out.specular_color, 3, owner);
    for (float &factor : out.base_color)
        factor = unit_factor(context, factor, owner, "diffuseFactor");
    for (float &factor : out.specular_color)
        factor = unit_factor(context, factor, owner, "specularFactor");
    out.glossiness = unit_factor(context, number_member(source, "glossinessFactor", 1.0, owner),
                                 owner, "glossinessFactor");
    out.base_texture =
        make_use(context, collector, extension_texture(source, "diffuseTexture", owner), owner);
    out.surface_texture = make_use(
        context, collector, extension_texture(source, "specularGlossinessTexture", owner), owner);
}

static void read_specular(import_context &context, texture_collector *collector,
                          const tinygltf::Value &source, const std::string &owner,
                          scene_material &out)
{
    out.specular_strength = unit_factor(
        context, number_member(source, "specularFactor", 1.0, owner), owner, "specularFactor");
    numbers_member(source, "specularColorFactor", out.specular_color, 3, owner);
    for (float &factor : out.specular_color)
        factor = positive_factor(factor, owner, "specularColorFactor");
    out.specular_texture =
        make_use(context, collector, extension_texture(source, "specularTexture", owner), owner);
    out.specular_color_texture = make_use(
        context, collector, extension_texture(source, "specularColorTexture", owner), owner);
}

// KHR_materials_ior: folded into the specular colour, which scales the reflectance 0.04 of the
// default index 1.5.
static void read_ior(const tinygltf::Value &source, const std::string &owner, scene_material &out)
{
    const double ior = number_member(source, "ior", 1.5, owner);
    if (ior != 0.0 && !(ior >= 1.0))
        fail_import(STATUS_FORMAT, "%s: ior %g is neither 0 nor at least 1", owner.c_str(), ior);
    const double root = (ior - 1.0) / (ior + 1.0);
    for (float &factor : out.specular_color)
        factor = finite_float(factor * root * root / 0.04, owner, "ior");
}

static void read_transmission(import_context &context, texture_collector *collector,
                              const tinygltf::Value &source, const std::string &owner,
                              scene_material &out)
{
    out.transmission = unit_factor(context, number_member(source, "transmissionFactor", 0.0, owner),
                                   owner, "transmissionFactor");
    out.transmission_texture = make_use(
        context, collector, extension_texture(source, "transmissionTexture", owner), owner);
}

static void read_diffuse_transmission(import_context &context, texture_collector *collector,
                                      const tinygltf::Value &source, const std::string &owner,
                                      scene_material &out)
{
    out.diffuse_transmission =
        unit_factor(context, number_member(source, "diffuseTransmissionFactor", 0.0, owner), owner,
                    "diffuseTransmissionFactor");
    numbers_member(source, "diffuseTransmissionColorFactor", out.diffuse_transmission_color, 3,
                   owner);
    for (float &factor : out.diffuse_transmission_color)
        factor = unit_factor(context, factor, owner, "diffuseTransmissionColorFactor");
    out.diffuse_transmission_texture = make_use(
        context, collector, extension_texture(source, "diffuseTransmissionTexture", owner), owner);
    out.diffuse_transmission_color_texture =
        make_use(context, collector,
                 extension_texture(source, "diffuseTransmissionColorTexture", owner), owner);
}

static void read_coat(import_context &context, texture_collector *collector,
                      const tinygltf::Value &source, const std::string &owner, scene_material &out)
{
    out.coat = unit_factor(context, number_member(source, "clearcoatFactor", 0.0, owner), owner,
                           "clearcoatFactor");
    out.coat_roughness =
        unit_factor(context, number_member(source, "clearcoatRoughnessFactor", 0.0, owner), owner,
                    "clearcoatRoughnessFactor");
    out.coat_texture =
        make_use(context, collector, extension_texture(source, "clearcoatTexture", owner), owner);
    out.coat_roughness_texture = make_use(
        context, collector, extension_texture(source, "clearcoatRoughnessTexture", owner), owner);
    const char *const normal = "clearcoatNormalTexture";
    out.coat_normal_texture =
        make_use(context, collector, extension_texture(source, normal, owner), owner);
    if (source.Has(normal))
        out.coat_normal_scale = finite_float(
            number_member(source.Get(std::string(normal)), "scale", 1.0, owner), owner, normal);
}

static void read_sheen(import_context &context, texture_collector *collector,
                       const tinygltf::Value &source, const std::string &owner, scene_material &out)
{
    numbers_member(source, "sheenColorFactor", out.sheen_color, 3, owner);
    for (float &factor : out.sheen_color)
        factor = unit_factor(context, factor, owner, "sheenColorFactor");
    out.sheen_roughness =
        unit_factor(context, number_member(source, "sheenRoughnessFactor", 0.0, owner), owner,
                    "sheenRoughnessFactor");
    out.sheen_color_texture =
        make_use(context, collector, extension_texture(source, "sheenColorTexture", owner), owner);
    out.sheen_roughness_texture = make_use(
        context, collector, extension_texture(source, "sheenRoughnessTexture", owner), owner);
}

// Reads what lies above the base, or lets light through it. None of it goes with
// specular-glossiness.
static void read_layers(import_context &context, texture_collector *collector,
                        const tinygltf::ExtensionMap &extensions, const std::string &owner,
                        scene_material &out)
{
    using reader = void (*)(import_context &, texture_collector *, const tinygltf::Value &,
                            const std::string &, scene_material &);
    const struct {
        const char *name;
        reader read;
    } layers[] = {{"KHR_materials_transmission", read_transmission},
                  {"KHR_materials_diffuse_transmission", read_diffuse_transmission},
                  {"KHR_materials_clearcoat", read_coat},
                  {"KHR_materials_sheen", read_sheen}};
    for (const auto &layer : layers) {
        const tinygltf::Value *source = find_extension(extensions, layer.name);
        if (source != nullptr)
            layer.read(context, collector, *source, owner, out);
    }
}

static void read_emission(import_context &context, texture_collector *collector,
                          const tinygltf::Material &source, const std::string &owner,
                          scene_material &out)
{
    double strength = 1.0;
    const tinygltf::Value *extension =
        find_extension(source.extensions, "KHR_materials_emissive_strength");
    if (extension != nullptr)
        strength = number_member(*extension, "emissiveStrength", 1.0, owner);
    for (size_t i = 0; i < 3; i++)
        out.emission[i] =
            positive_factor(source.emissiveFactor[i] * strength, owner, "emissiveFactor");
    out.emissive_texture =
        make_use(context, collector, core_texture(source.emissiveTexture), owner);
}

static void read_alpha(const tinygltf::Material &source, const std::string &owner,
                       scene_material &out)
{
    out.masked = source.alphaMode == "MASK";
    out.alpha_cutoff = positive_factor(source.alphaCutoff, owner, "alphaCutoff");
    out.blended = source.alphaMode == "BLEND";
    if (!out.masked && !out.blended && source.alphaMode != "OPAQUE")
        fail_import(STATUS_FORMAT, "%s: alphaMode \"%s\" does not exist", owner.c_str(),
                    source.alphaMode.c_str());
}

// Converts one material. Textures of unused ones are left out: collector is NULL.
static scene_material convert(import_context &context, texture_collector *collector,
                              const tinygltf::Material &source, const std::string &owner)
{
    scene_material out = default_material(context);
    out.name = arena_text(context, source.name);
    const tinygltf::ExtensionMap &extensions = source.extensions;
    const tinygltf::Value *glossiness =
        find_extension(extensions, "KHR_materials_pbrSpecularGlossiness");
    const tinygltf::Value *specular = find_extension(extensions, "KHR_materials_specular");
    if (glossiness != nullptr)
        read_specular_glossiness(context, collector, *glossiness, owner, out);
    else
        read_metallic_roughness(context, collector, source.pbrMetallicRoughness, owner, out);
    if (glossiness == nullptr && specular != nullptr)
        read_specular(context, collector, *specular, owner, out);
    const tinygltf::Value *ior = find_extension(extensions, "KHR_materials_ior");
    if (glossiness == nullptr && ior != nullptr)
        read_ior(*ior, owner, out);
    if (glossiness == nullptr)
        read_layers(context, collector, extensions, owner, out);
    read_emission(context, collector, source, owner, out);
    read_alpha(source, owner, out);
    out.double_sided = source.doubleSided;
    out.unlit = find_extension(extensions, "KHR_materials_unlit") != nullptr;
    out.normal_texture = make_use(context, collector, core_texture(source.normalTexture), owner);
    out.normal_scale = finite_float(source.normalTexture.scale, owner, "normalTexture.scale");
    return out;
}

int normal_map_texcoord(const import_context &context, int material)
{
    if (material < 0 || static_cast<size_t>(material) >= context.model.materials.size())
        return -1;
    const tinygltf::Material &source = context.model.materials[static_cast<size_t>(material)];
    const std::string owner = label("material", static_cast<size_t>(material), source.name);
    texture_reference map = core_texture(source.normalTexture);
    const tinygltf::Value *coat = find_extension(source.extensions, "KHR_materials_clearcoat");
    if (map.index < 0 && coat != nullptr)
        map = extension_texture(*coat, "clearcoatNormalTexture", owner);
    if (map.index < 0)
        return -1;
    return texcoord_of(map, owner) == 1 ? 1 : 0;
}

void load_materials(import_context &context)
{
    texture_collector collector;
    const std::vector<tinygltf::Material> &sources = context.model.materials;
    for (size_t i = 0; i < sources.size(); i++)
        context.materials.push_back(convert(context,
                                            context.material_used[i] ? &collector : nullptr,
                                            sources[i], label("material", i, sources[i].name)));
    if (context.material_used[sources.size()])
        context.materials.push_back(default_material(context));
    load_images(context, collector);
}
