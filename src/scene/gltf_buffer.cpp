#include "scene/gltf_buffer.hpp"

#include <cctype>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

#include <sys/stat.h>

// A file is read in pieces of this size, as the size of standard input is not known.
static const size_t READ_SIZE = (size_t)1 << 20;

// Size of an open regular file; 0 if it is none. Folders are refused.
static size_t regular_size(FILE *file, const char *path, const std::string &owner)
{
    struct stat info;
    if (fstat(fileno(file), &info) != 0)
        return 0;
    if (S_ISDIR(info.st_mode))
        fail_import(STATUS_IO, "%s: \"%s\" is a folder", owner.c_str(), path);
    return S_ISREG(info.st_mode) ? static_cast<size_t>(info.st_size) : 0;
}

std::vector<uint8_t> read_whole_file(const char *path, const std::string &owner)
{
    std::unique_ptr<FILE, int (*)(FILE *)> opened(nullptr, fclose);
    FILE *file = stdin;
    if (path != nullptr) {
        opened.reset(fopen(path, "rb"));
        file = opened.get();
        if (file == nullptr)
            fail_import(STATUS_IO, "%s: cannot open \"%s\": %s", owner.c_str(), path,
                        strerror(errno));
    }

    // One byte more than the size, so that the end is seen without growing.
    std::vector<uint8_t> bytes(regular_size(file, path, owner) + 1);
    size_t used = 0;
    for (;;) {
        if (used == bytes.size())
            bytes.resize(bytes.size() + bytes.size() / 2 + READ_SIZE);
        const size_t got = fread(bytes.data() + used, 1, bytes.size() - used, file);
        used += got;
        if (got == 0)
            break;
    }
    if (ferror(file))
        fail_import(STATUS_IO, "%s: cannot read \"%s\": %s", owner.c_str(),
                    path != nullptr ? path : "standard input", strerror(errno));
    bytes.resize(used);
    return bytes;
}

bool is_data_uri(const std::string &uri)
{
    return uri.compare(0, 5, "data:") == 0;
}

// Turns %XX into bytes.
static std::string percent_decode(const std::string &text)
{
    std::string out;
    for (size_t i = 0; i < text.size(); i++) {
        unsigned code;
        if (text[i] == '%' && i + 2 < text.size() &&
            isxdigit(static_cast<unsigned char>(text[i + 1])) &&
            isxdigit(static_cast<unsigned char>(text[i + 2])) &&
            sscanf(text.c_str() + i + 1, "%2x", &code) == 1) {
            out.push_back(static_cast<char>(code));
            i += 2;
        } else {
            out.push_back(text[i]);
        }
    }
    return out;
}

// Has it a scheme, as http: or file: have?
static bool has_scheme(const std::string &uri)
{
    const size_t colon = uri.find_first_of(":/?#");
    return colon != std::string::npos && colon > 0 && uri[colon] == ':' &&
           isalpha(static_cast<unsigned char>(uri[0]));
}

// Does a relative path step out of the folder it starts from?
static bool leaves_folder(const std::string &path)
{
    int depth = 0;
    size_t begin = 0;
    while (begin <= path.size()) {
        size_t end = path.find('/', begin);
        if (end == std::string::npos)
            end = path.size();
        const std::string part = path.substr(begin, end - begin);
        if (part == "..")
            depth--;
        else if (!part.empty() && part != ".")
            depth++;
        if (depth < 0)
            return true;
        begin = end + 1;
    }
    return false;
}

// The values of base64 digits, both alphabets; 255 for other characters.
static std::vector<uint8_t> base64_values()
{
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::vector<uint8_t> values(256, 255);
    for (uint8_t i = 0; i < 64; i++)
        values[static_cast<unsigned char>(digits[i])] = i;
    values['-'] = 62;
    values['_'] = 63;
    return values;
}

static std::vector<uint8_t> decode_base64(const char *at, const char *end, const std::string &owner)
{
    static const std::vector<uint8_t> values = base64_values();
    while (end > at && end[-1] == '=')
        end--;
    std::vector<uint8_t> out;
    out.reserve(static_cast<size_t>(end - at) / 4 * 3 + 3);
    uint32_t bits = 0;
    int bit_count = 0;
    for (; at < end; at++) {
        const uint8_t value = values[static_cast<unsigned char>(*at)];
        if (value == 255)
            fail_import(STATUS_FORMAT, "%s: its data: URI is not base64", owner.c_str());
        bits = (bits << 6) | value;
        bit_count += 6;
        if (bit_count >= 8) {
            bit_count -= 8;
            out.push_back(static_cast<uint8_t>(bits >> bit_count));
        }
    }
    return out;
}

static std::vector<uint8_t> decode_data_uri(const std::string &uri, const std::string &owner)
{
    const size_t comma = uri.find(',');
    if (comma == std::string::npos)
        fail_import(STATUS_FORMAT, "%s: its data: URI has no comma", owner.c_str());
    const std::string head = uri.substr(0, comma);
    static const std::string mark = ";base64";
    const char *const data = uri.c_str() + comma + 1;
    if (head.size() >= mark.size() &&
        head.compare(head.size() - mark.size(), mark.size(), mark) == 0)
        return decode_base64(data, uri.c_str() + uri.size(), owner);
    const std::string plain = percent_decode(uri.substr(comma + 1));
    return std::vector<uint8_t>(plain.begin(), plain.end());
}

std::vector<uint8_t> fetch_uri(const import_context &context, const std::string &uri,
                               const std::string &owner)
{
    if (is_data_uri(uri))
        return decode_data_uri(uri, owner);
    if (!context.has_folder)
        fail_import(STATUS_IO,
                    "%s: \"%s\" cannot be found from standard input; embed it in the file",
                    owner.c_str(), uri.c_str());
    if (has_scheme(uri))
        fail_import(STATUS_UNSUPPORTED,
                    "%s: \"%s\" is no file; only files beside the scene are read", owner.c_str(),
                    uri.c_str());
    const std::string path = percent_decode(uri);
    if (path.empty() || path[0] == '/' || path.find('\0') != std::string::npos ||
        leaves_folder(path))
        fail_import(STATUS_FORMAT, "%s: \"%s\" is not inside the scene's folder; copy it there",
                    owner.c_str(), uri.c_str());

    const std::string full = context.folder + path;
    struct stat info;
    if (stat(full.c_str(), &info) == 0 && !S_ISREG(info.st_mode))
        fail_import(STATUS_IO, "%s: \"%s\" is no regular file", owner.c_str(), full.c_str());
    return read_whole_file(full.c_str(), owner);
}

// Fetches a buffer's bytes if they are not there yet.
static byte_span buffer_bytes(import_context &context, int index, const std::string &owner)
{
    if (index < 0 || static_cast<size_t>(index) >= context.buffers.size())
        fail_import(STATUS_FORMAT, "%s: there is no buffer %d", owner.c_str(), index);
    loaded_buffer &loaded = context.loaded_buffers[static_cast<size_t>(index)];
    if (loaded.is_loaded)
        return loaded.bytes;

    const data_source &source = context.buffers[static_cast<size_t>(index)];
    const std::string name = label("buffer", static_cast<size_t>(index), source.name);
    if (!source.uri.empty()) {
        loaded.storage = fetch_uri(context, source.uri, name);
        loaded.bytes = {loaded.storage.data(), loaded.storage.size()};
    } else if (index == 0 && context.binary_chunk.data != nullptr) {
        loaded.bytes = context.binary_chunk;
    } else {
        fail_import(STATUS_UNSUPPORTED,
                    "%s: %s has neither a uri nor a binary chunk; if it is the fallback of a "
                    "compression extension, export without compression",
                    owner.c_str(), name.c_str());
    }
    const size_t wanted = static_cast<size_t>(source.byte_length);
    if (loaded.bytes.size < wanted)
        fail_import(STATUS_FORMAT, "%s: byteLength is %zu, but there are only %zu bytes",
                    name.c_str(), wanted, loaded.bytes.size);
    loaded.bytes.size = wanted;
    loaded.is_loaded = true;
    return loaded.bytes;
}

byte_span view_bytes(import_context &context, int64_t view_index, const std::string &owner)
{
    if (view_index < 0 || static_cast<uint64_t>(view_index) >= context.model.bufferViews.size())
        fail_import(STATUS_FORMAT, "%s: there is no buffer view %lld", owner.c_str(),
                    static_cast<long long>(view_index));
    const tinygltf::BufferView &view = context.model.bufferViews[static_cast<size_t>(view_index)];
    const byte_span bytes = buffer_bytes(context, view.buffer, owner);
    if (view.byteOffset > bytes.size || view.byteLength > bytes.size - view.byteOffset)
        fail_import(STATUS_FORMAT,
                    "%s: buffer view %lld (offset %zu, length %zu) leaves buffer %d of %zu bytes",
                    owner.c_str(), static_cast<long long>(view_index), view.byteOffset,
                    view.byteLength, view.buffer, bytes.size);
    return {bytes.data + view.byteOffset, view.byteLength};
}
