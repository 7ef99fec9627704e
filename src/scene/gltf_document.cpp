#include "scene/gltf_document.hpp"

#include <algorithm>
#include <cstring>

#include "scene/gltf_buffer.hpp"
#include "scene/gltf_json.hpp"

// tinygltf takes 32-bit sizes.
static const size_t MAX_JSON_SIZE = (size_t)1 << 31;

static const uint32_t GLB_MAGIC = 0x46546c67;      // "glTF"
static const uint32_t GLB_CHUNK_JSON = 0x4e4f534a; // "JSON"
static const uint32_t GLB_CHUNK_BIN = 0x004e4942;  // "BIN"

// Stands in for each buffer while tinygltf parses.
static const char BUFFER_STUB[] =
    "{\"byteLength\":1,\"uri\":\"data:application/octet-stream;base64,AA==\"}";

// Extensions that change the picture and are implemented, or do not touch it.
static const char *const SUPPORTED[] = {"EXT_lights_area",
                                        "EXT_lights_image_based",
                                        "EXT_mesh_gpu_instancing",
                                        "EXT_texture_webp",
                                        "KHR_lights_punctual",
                                        "KHR_materials_clearcoat",
                                        "KHR_materials_diffuse_transmission",
                                        "KHR_materials_emissive_strength",
                                        "KHR_materials_ior",
                                        "KHR_materials_pbrSpecularGlossiness",
                                        "KHR_materials_sheen",
                                        "KHR_materials_specular",
                                        "KHR_materials_transmission",
                                        "KHR_materials_unlit",
                                        "KHR_materials_variants",
                                        "KHR_mesh_quantization",
                                        "KHR_node_visibility",
                                        "KHR_texture_transform",
                                        "KHR_xmp",
                                        "KHR_xmp_json_ld"};

// Extensions whose fallback is used in silence where the file does not require them.
static const char *const REPLACEABLE[] = {"EXT_meshopt_compression",    "KHR_meshopt_compression",
                                          "KHR_draco_mesh_compression", "KHR_texture_basisu",
                                          "MSFT_texture_dds",           "EXT_texture_avif"};

static uint32_t read_u32(const uint8_t *at)
{
    return at[0] | at[1] << 8 | at[2] << 16 | static_cast<uint32_t>(at[3]) << 24;
}

// Finds the JSON and binary chunks of a GLB.
static byte_span split_glb(import_context &context)
{
    const std::vector<uint8_t> &file = context.file;
    if (file.size() < 12)
        fail_import(STATUS_FORMAT, "the GLB header is cut short");
    const uint32_t version = read_u32(&file[4]);
    const size_t length = read_u32(&file[8]);
    if (version != 2)
        fail_import(STATUS_UNSUPPORTED, "GLB version %u; only version 2 is supported", version);
    if (length > file.size() || length < 12)
        fail_import(STATUS_FORMAT, "the GLB says it has %zu bytes, but there are %zu", length,
                    file.size());

    byte_span json;
    size_t at = 12;
    for (int chunk = 0; at < length; chunk++) {
        if (length - at < 8)
            fail_import(STATUS_FORMAT, "header of GLB chunk %d is cut short", chunk);
        const size_t chunk_length = read_u32(&file[at]);
        const uint32_t type = read_u32(&file[at + 4]);
        at += 8;
        if (chunk_length > length - at)
            fail_import(STATUS_FORMAT, "GLB chunk %d has %zu bytes, but only %zu are left", chunk,
                        chunk_length, length - at);
        if (chunk == 0 && type == GLB_CHUNK_JSON)
            json = {file.data() + at, chunk_length};
        else if (chunk == 1 && type == GLB_CHUNK_BIN)
            context.binary_chunk = {file.data() + at, chunk_length};
        at += std::min((chunk_length + 3) / 4 * 4, length - at);
    }
    if (json.data == nullptr)
        fail_import(STATUS_FORMAT, "the GLB has no JSON chunk");
    return json;
}

// Reads the elements of "buffers" or "images".
static std::vector<data_source> read_sources(json_span array, const char *kind)
{
    if (array.begin != nullptr && *array.begin != '[')
        fail_import(STATUS_FORMAT, "\"%ss\" is not an array", kind);
    std::vector<data_source> sources;
    for (const json_span &element : json_elements(array)) {
        const std::string owner = kind + (" " + std::to_string(sources.size()));
        if (*element.begin != '{')
            fail_import(STATUS_FORMAT, "%s is not an object", owner.c_str());
        const std::vector<json_member> members = json_members(element);
        const json_span name = json_find(members, "name");
        const json_span uri = json_find(members, "uri");
        const json_span length = json_find(members, "byteLength");
        const json_span view = json_find(members, "bufferView");
        data_source source;
        json_string(name, &source.name);
        if (uri.begin != nullptr && !json_string(uri, &source.uri))
            fail_import(STATUS_FORMAT, "%s: uri is not a string", owner.c_str());
        if (view.begin != nullptr && !json_whole_number(view, &source.buffer_view))
            fail_import(STATUS_FORMAT, "%s: bufferView is not an index", owner.c_str());
        if (strcmp(kind, "buffer") == 0 && !json_whole_number(length, &source.byte_length))
            fail_import(STATUS_FORMAT, "%s: byteLength is missing or no size", owner.c_str());
        sources.push_back(std::move(source));
    }
    return sources;
}

// Refuses top-level members of the wrong type, which tinygltf takes for missing.
static void check_types(const std::vector<json_member> &members)
{
    static const char *const arrays[] = {
        "accessors", "animations", "buffers",  "bufferViews",    "cameras",
        "images",    "materials",  "meshes",   "nodes",          "samplers",
        "scenes",    "skins",      "textures", "extensionsUsed", "extensionsRequired"};
    for (const json_member &member : members) {
        const char first = *member.value.begin;
        for (const char *name : arrays) {
            if (member.name == name && first != '[')
                fail_import(STATUS_FORMAT, "\"%s\" is not an array", name);
        }
        if ((member.name == "asset" || member.name == "extensions") && first != '{')
            fail_import(STATUS_FORMAT, "\"%s\" is not an object", member.name.c_str());
        if (member.name == "scene" && (first < '0' || first > '9'))
            fail_import(STATUS_FORMAT, "\"scene\" is not an index");
    }
}

// The line ends of a stretch of text, so that messages of the parser name the right line.
static std::string line_ends(json_span text)
{
    return std::string(static_cast<size_t>(std::count(text.begin, text.end, '\n')), '\n');
}

// tinygltf refuses indices whose accessor has no buffer view, which glTF allows. Such accessors get
// an extra view behind those of the file, which forget_extra_view() takes back.
static std::string patch_accessors(json_span array, size_t extra_view, std::vector<bool> *patched)
{
    std::string text;
    const char *at = array.begin;
    patched->clear();
    for (const json_span &element : json_elements(array)) {
        const std::vector<json_member> members = json_members(element);
        const bool is_patched =
            *element.begin == '{' && json_find(members, "bufferView").begin == nullptr;
        patched->push_back(is_patched);
        if (!is_patched)
            continue;
        text.append(at, element.begin);
        text += "{\"bufferView\":" + std::to_string(extra_view);
        text += members.empty() ? "" : ",";
        at = element.begin + 1;
    }
    return text.append(at, array.end);
}

static void forget_extra_view(tinygltf::Model &model, const std::vector<bool> &patched)
{
    if (!model.bufferViews.empty())
        model.bufferViews.pop_back();
    for (size_t i = 0; i < model.accessors.size() && i < patched.size(); i++) {
        if (patched[i])
            model.accessors[i].bufferView = -1;
    }
}

// The file's buffer views and one more.
static std::string extend_views(json_span array)
{
    static const std::string extra = "{\"buffer\":0,\"byteLength\":1}";
    const bool is_empty = json_elements(array).empty();
    if (is_empty)
        return "[" + extra + "]" + line_ends(array);
    return std::string(array.begin, array.end - 1) + "," + extra + "]";
}

static std::string stub_buffers(json_span array, size_t count)
{
    std::string text = "[";
    for (size_t i = 0; i < count; i++)
        text += (i > 0 ? "," : "") + std::string(BUFFER_STUB);
    return text + "]" + line_ends(array);
}

// The JSON text with stubs for buffers, without images and animations, and with the extra view.
static std::string rewrite_json(import_context &context, const char *text, size_t size,
                                std::vector<bool> *patched)
{
    const json_span root = json_root(text, size);
    if (*root.begin != '{')
        fail_import(STATUS_FORMAT, "not a glTF file: the JSON text holds no object");
    const std::vector<json_member> members = json_members(root);
    check_types(members);
    context.buffers = read_sources(json_find(members, "buffers"), "buffer");
    context.images = read_sources(json_find(members, "images"), "image");
    context.has_animations = !json_elements(json_find(members, "animations")).empty();
    const json_span views = json_find(members, "bufferViews");
    const size_t view_count = json_elements(views).size();

    std::string out(text, root.begin + 1);
    if (views.begin == nullptr)
        out += "\"bufferViews\":" + extend_views(views) + (members.empty() ? "" : ",");
    const char *at = root.begin + 1;
    for (const json_member &member : members) {
        out.append(at, member.value.begin);
        at = member.value.end;
        if (member.name == "buffers")
            out += stub_buffers(member.value, context.buffers.size());
        else if (member.name == "bufferViews")
            out += extend_views(member.value);
        else if (member.name == "accessors")
            out += patch_accessors(member.value, view_count, patched);
        else if (member.name == "images" || member.name == "animations")
            out += "[" + line_ends(member.value) + "]";
        else
            out.append(member.value.begin, member.value.end);
    }
    return out.append(at, text + size);
}

// What tinygltf complains of though the file is right.
static std::string real_errors(const std::string &errors)
{
    std::string real;
    size_t begin = 0;
    while (begin < errors.size()) {
        size_t end = errors.find('\n', begin);
        if (end == std::string::npos)
            end = errors.size();
        const std::string line = errors.substr(begin, end - begin);
        if (!line.empty() && line.find("'inverseBindMatrices' property is missing") != 0)
            real += (real.empty() ? "" : "; ") + line;
        begin = end + 1;
    }
    return real;
}

// Takes the folder of external files from the scene's path.
static void find_folder(import_context &context)
{
    context.has_folder = strcmp(context.path, "-") != 0;
    const char *slash = strrchr(context.path, '/');
    if (context.has_folder && slash != nullptr)
        context.folder.assign(context.path, static_cast<size_t>(slash - context.path) + 1);
}

static void check_version(const import_context &context)
{
    const tinygltf::Asset &asset = context.model.asset;
    if (asset.version.empty())
        fail_import(STATUS_FORMAT, "not a glTF file: it has no asset.version");
    if (asset.version.compare(0, 2, "2.") != 0)
        fail_import(STATUS_UNSUPPORTED, "glTF version \"%s\"; only 2.x is supported",
                    asset.version.c_str());
    if (!asset.minVersion.empty() && asset.minVersion != "2.0")
        fail_import(STATUS_UNSUPPORTED, "it needs glTF version \"%s\"; only 2.0 is supported",
                    asset.minVersion.c_str());
}

static bool is_listed(const std::string &name, const char *const *list, size_t count)
{
    return std::any_of(list, list + count, [&](const char *entry) { return name == entry; });
}

// Refuses required extensions that are not implemented; warns of optional ones.
static void check_extensions(import_context &context)
{
    const size_t supported_count = sizeof(SUPPORTED) / sizeof(SUPPORTED[0]);
    const size_t replaceable_count = sizeof(REPLACEABLE) / sizeof(REPLACEABLE[0]);
    for (const std::string &name : context.model.extensionsRequired) {
        if (!is_listed(name, SUPPORTED, supported_count))
            fail_import(STATUS_UNSUPPORTED,
                        "it requires the extension %s, which is not supported; export without it",
                        name.c_str());
    }
    std::string ignored;
    for (const std::string &name : context.model.extensionsUsed) {
        if (!is_listed(name, SUPPORTED, supported_count) &&
            !is_listed(name, REPLACEABLE, replaceable_count))
            ignored += (ignored.empty() ? "" : ", ") + name;
    }
    if (!ignored.empty())
        warn_once(context, "extensions", "extensions that are not supported are ignored: %s",
                  ignored.c_str());
}

void load_document(import_context &context)
{
    find_folder(context);
    context.file = read_whole_file(context.has_folder ? context.path : nullptr, "scene");

    // Find the JSON text, less a byte order mark.
    byte_span json = {context.file.data(), context.file.size()};
    if (json.size == 0)
        fail_import(STATUS_FORMAT, "the file is empty");
    if (json.size >= 4 && read_u32(json.data) == GLB_MAGIC)
        json = split_glb(context);
    if (json.size >= 3 && memcmp(json.data, "\xef\xbb\xbf", 3) == 0)
        json = {json.data + 3, json.size - 3};
    if (json.size >= MAX_JSON_SIZE)
        fail_import(STATUS_LIMIT, "%zu bytes of JSON text; move data out of it", json.size);
    std::vector<bool> patched;
    const std::string text =
        rewrite_json(context, reinterpret_cast<const char *>(json.data), json.size, &patched);
    context.loaded_buffers.resize(context.buffers.size());

    tinygltf::TinyGLTF parser;
    std::string errors;
    std::string warnings;
    const bool parsed = parser.LoadASCIIFromString(&context.model, &errors, &warnings, text.c_str(),
                                                   static_cast<unsigned>(text.size()), "");
    check_version(context);
    check_extensions(context);
    forget_extra_view(context.model, patched);
    const std::string real = real_errors(errors);
    if (!real.empty())
        fail_import(STATUS_FORMAT, "%s", real.c_str());
    if (!parsed)
        fail_import(STATUS_FORMAT, "not a glTF file");
}
