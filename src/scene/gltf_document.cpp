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
static const char *const SUPPORTED[] = {"EXT_mesh_gpu_instancing",
                                        "EXT_texture_webp",
                                        "KHR_lights_punctual",
                                        "KHR_materials_emissive_strength",
                                        "KHR_materials_ior",
                                        "KHR_materials_pbrSpecularGlossiness",
                                        "KHR_materials_specular",
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

// The JSON text without what tinygltf need not see.
static std::string strip_json(import_context &context, const char *text, size_t size)
{
    const json_span root = json_root(text, size);
    if (*root.begin != '{')
        fail_import(STATUS_FORMAT, "not a glTF file: the JSON text holds no object");
    const std::vector<json_member> members = json_members(root);
    context.buffers = read_sources(json_find(members, "buffers"), "buffer");
    context.images = read_sources(json_find(members, "images"), "image");

    std::string buffers;
    for (size_t i = 0; i < context.buffers.size(); i++)
        buffers += (i > 0 ? "," : "") + std::string(BUFFER_STUB);
    std::string stripped;
    const char *at = text;
    for (const json_member &member : members) {
        const bool is_buffers = member.name == "buffers";
        const bool is_animations = member.name == "animations";
        if (!is_buffers && !is_animations && member.name != "images")
            continue;
        if (is_animations)
            context.has_animations = !json_elements(member.value).empty();
        stripped.append(at, member.value.begin);
        stripped += "[" + (is_buffers ? buffers : std::string()) + "]";
        at = member.value.end;
    }
    stripped.append(at, text + size);
    return stripped;
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
    const std::string text =
        strip_json(context, reinterpret_cast<const char *>(json.data), json.size);
    context.loaded_buffers.resize(context.buffers.size());

    tinygltf::TinyGLTF parser;
    std::string errors;
    std::string warnings;
    const bool parsed = parser.LoadASCIIFromString(&context.model, &errors, &warnings, text.c_str(),
                                                   static_cast<unsigned>(text.size()), "");
    check_extensions(context);
    const std::string real = real_errors(errors);
    if (!real.empty())
        fail_import(STATUS_FORMAT, "%s", real.c_str());
    if (!parsed)
        fail_import(STATUS_FORMAT, "not a glTF file");
}

static bool is_listed(const std::string &name, const char *const *list, size_t count)
{
    return std::any_of(list, list + count, [&](const char *entry) { return name == entry; });
}

void check_extensions(import_context &context)
{
    const std::string &version = context.model.asset.version;
    if (version.compare(0, 2, "2.") != 0)
        fail_import(STATUS_UNSUPPORTED, "glTF version \"%s\"; only 2.x is supported",
                    version.c_str());
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
