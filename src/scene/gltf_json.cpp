#include "scene/gltf_json.hpp"

#include <cstring>

#include "scene/gltf_context.hpp"

// Real files nest less than 20 deep; parsers that recurse keep well within their stack here.
static const int MAX_DEPTH = 128;

static const char *skip_space(const char *at, const char *end)
{
    while (at < end && (*at == ' ' || *at == '\t' || *at == '\n' || *at == '\r'))
        at++;
    return at;
}

// From the opening quote to behind the closing one.
static const char *skip_string(const char *at, const char *end)
{
    for (at++; at < end; at++) {
        if (*at == '\\')
            at++;
        else if (*at == '"')
            return at + 1;
    }
    fail_import(STATUS_FORMAT, "a string in the JSON text has no end");
}

// To behind a number or a word.
static const char *skip_word(const char *at, const char *end)
{
    const char *const begin = at;
    while (at < end && strchr(" \t\n\r,:]}[{\"", *at) == nullptr)
        at++;
    if (at == begin)
        fail_import(STATUS_FORMAT, "the JSON text has a value missing");
    return at;
}

// To behind a value of any kind.
static const char *skip_value(const char *at, const char *end)
{
    if (at >= end)
        fail_import(STATUS_FORMAT, "the JSON text ends too early");
    if (*at == '"')
        return skip_string(at, end);
    if (*at != '{' && *at != '[')
        return skip_word(at, end);

    char closing[MAX_DEPTH];
    int depth = 0;
    while (at < end) {
        if (*at == '"') {
            at = skip_string(at, end);
            continue;
        }
        if (*at == '{' || *at == '[') {
            if (depth == MAX_DEPTH)
                fail_import(STATUS_FORMAT, "the JSON text nests more than %d deep", MAX_DEPTH);
            closing[depth++] = *at == '{' ? '}' : ']';
        } else if (*at == '}' || *at == ']') {
            if (closing[--depth] != *at)
                fail_import(STATUS_FORMAT, "brackets of the JSON text do not match");
            if (depth == 0)
                return at + 1;
        }
        at++;
    }
    fail_import(STATUS_FORMAT, "the JSON text ends too early: a bracket has no end");
}

json_span json_root(const char *text, size_t size)
{
    const char *const end = text + size;
    json_span root;
    root.begin = skip_space(text, end);
    root.end = skip_value(root.begin, end);
    return root;
}

std::vector<json_member> json_members(json_span object)
{
    std::vector<json_member> members;
    if (object.begin == nullptr || *object.begin != '{')
        return members;
    const char *const end = object.end - 1;
    const char *at = skip_space(object.begin + 1, end);
    while (at < end) {
        // Take `"name" : value`, and the comma behind it.
        json_member member;
        const char *const name = at;
        if (*at != '"')
            fail_import(STATUS_FORMAT, "an object of the JSON text has a member without a name");
        at = skip_string(at, end);
        if (!json_string({name, at}, &member.name))
            fail_import(STATUS_FORMAT, "a name in the JSON text has a bad escape");
        at = skip_space(at, end);
        if (at == end || *at != ':')
            fail_import(STATUS_FORMAT, "member \"%s\" of the JSON text has no value",
                        member.name.c_str());
        member.value.begin = skip_space(at + 1, end);
        at = member.value.end = skip_value(member.value.begin, end);
        members.push_back(std::move(member));
        at = skip_space(at, end);
        if (at < end && *at != ',')
            fail_import(STATUS_FORMAT, "the JSON text lacks a comma");
        if (at < end)
            at = skip_space(at + 1, end);
    }
    return members;
}

std::vector<json_span> json_elements(json_span array)
{
    std::vector<json_span> elements;
    if (array.begin == nullptr || *array.begin != '[')
        return elements;
    const char *const end = array.end - 1;
    const char *at = skip_space(array.begin + 1, end);
    while (at < end) {
        const char *const begin = at;
        at = skip_value(begin, end);
        elements.push_back({begin, at});
        at = skip_space(at, end);
        if (at < end && *at != ',')
            fail_import(STATUS_FORMAT, "the JSON text lacks a comma");
        if (at < end)
            at = skip_space(at + 1, end);
    }
    return elements;
}

json_span json_find(const std::vector<json_member> &members, const char *name)
{
    json_span found;
    for (const json_member &member : members) {
        if (member.name == name)
            found = member.value;
    }
    return found;
}

// Reads four hexadecimal digits; -1 if they are none.
static int read_hex4(const char *at, const char *end)
{
    if (end - at < 4)
        return -1;
    int code = 0;
    for (int i = 0; i < 4; i++) {
        const char c = at[i];
        const int digit = c >= '0' && c <= '9'   ? c - '0'
                          : c >= 'a' && c <= 'f' ? c - 'a' + 10
                          : c >= 'A' && c <= 'F' ? c - 'A' + 10
                                                 : -1;
        if (digit < 0)
            return -1;
        code = code * 16 + digit;
    }
    return code;
}

static void append_utf8(std::string *out, uint32_t code)
{
    if (code < 0x80) {
        out->push_back(static_cast<char>(code));
        return;
    }
    const int extra = code < 0x800 ? 1 : code < 0x10000 ? 2 : 3;
    static const uint32_t lead[] = {0, 0xc0, 0xe0, 0xf0};
    out->push_back(static_cast<char>(lead[extra] | (code >> (6 * extra))));
    for (int i = extra - 1; i >= 0; i--)
        out->push_back(static_cast<char>(0x80 | ((code >> (6 * i)) & 0x3f)));
}

// Decodes the escape whose letter stands at *at, and leaves *at on its last character.
static bool decode_escape(const char **at, const char *end, std::string *out)
{
    static const char letters[] = "\"\\/bfnrt";
    static const char meanings[] = "\"\\/\b\f\n\r\t";
    if (**at != 'u') {
        const char *letter = **at != '\0' ? strchr(letters, **at) : nullptr;
        if (letter == nullptr)
            return false;
        out->push_back(meanings[letter - letters]);
        return true;
    }
    const int high = read_hex4(*at + 1, end);
    if (high < 0)
        return false;
    *at += 4;
    uint32_t code = static_cast<uint32_t>(high);
    if (code >= 0xd800 && code < 0xdc00 && end - *at > 6 && (*at)[1] == '\\' && (*at)[2] == 'u') {
        const int low = read_hex4(*at + 3, end);
        if (low >= 0xdc00 && low < 0xe000) {
            code = 0x10000 + ((code - 0xd800) << 10) + (static_cast<uint32_t>(low) - 0xdc00);
            *at += 6;
        }
    }
    append_utf8(out, code);
    return true;
}

bool json_string(json_span value, std::string *out)
{
    if (value.begin == nullptr || *value.begin != '"')
        return false;
    const char *const end = value.end - 1;
    out->clear();
    const char *at = value.begin + 1;
    while (at < end) {
        // Copy a run without escapes, which a data: URI is from end to end.
        const void *escape = memchr(at, '\\', static_cast<size_t>(end - at));
        const char *const run_end = escape != nullptr ? static_cast<const char *>(escape) : end;
        out->append(at, run_end);
        at = run_end;
        if (at == end)
            break;
        at++;
        if (at == end || !decode_escape(&at, end, out))
            return false;
        at++;
    }
    return true;
}

bool json_whole_number(json_span value, int64_t *out)
{
    if (value.begin == nullptr || value.end - value.begin > 16)
        return false;
    int64_t number = 0;
    for (const char *at = value.begin; at < value.end; at++) {
        if (*at < '0' || *at > '9')
            return false;
        number = number * 10 + (*at - '0');
    }
    *out = number;
    return number <= (int64_t)1 << 53;
}
