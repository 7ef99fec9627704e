/**
 * @file
 * A glance at JSON text before the real parser sees it: how deep it nests, and where the members of
 * an object and the elements of an array stand. It never reads outside the text; what it lets pass
 * may still be refused by the parser.
 */
#ifndef SCENE_GLTF_JSON_HPP
#define SCENE_GLTF_JSON_HPP

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/** A stretch of JSON text: one value, without white space around it. */
struct json_span {
    const char *begin = nullptr; // nullptr: there is none
    const char *end = nullptr;
};

struct json_member {
    std::string name;
    json_span value;
};

/** The value that the text holds. Fails if brackets or quotes do not match, or nest too deep. */
json_span json_root(const char *text, size_t size);

/** Members of an object in their order; empty if the value is no object. */
std::vector<json_member> json_members(json_span object);

/** Elements of an array; empty if the value is no array. */
std::vector<json_span> json_elements(json_span array);

/** The last member of this name, as the parser takes it; begin is nullptr if there is none. */
json_span json_find(const std::vector<json_member> &members, const char *name);

/** Decodes a string; false if the value is none, or has a bad escape. */
bool json_string(json_span value, std::string *out);

/** Reads a whole number, 0 .. 2^53; false if the value is none. */
bool json_whole_number(json_span value, int64_t *out);

#endif
