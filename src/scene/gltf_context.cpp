#include "scene/gltf_context.hpp"

#include <cmath>
#include <cstdarg>
#include <cstdio>

extern "C" {
#include "core/log.h"
}

// Messages longer than this are cut.
static const size_t MESSAGE_SIZE = 2048;

void fail_import(enum status code, const char *format, ...)
{
    char text[MESSAGE_SIZE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof(text), format, args);
    va_end(args);
    throw import_failure{code, text};
}

void warn_once(import_context &context, const char *kind, const char *format, ...)
{
    if (!context.warned.insert(kind).second)
        return;
    char text[MESSAGE_SIZE];
    va_list args;
    va_start(args, format);
    vsnprintf(text, sizeof(text), format, args);
    va_end(args);
    log_message(LOG_WARNING, "%s: %s", context.name, text);
}

const char *arena_text(import_context &context, const std::string &text)
{
    char *copy = arena_strdup(&context.scene->arena, text.c_str());
    if (copy == nullptr)
        fail_import(STATUS_NO_MEMORY, "a name of %zu bytes does not fit", text.size());
    return copy;
}

std::string label(const char *kind, size_t index, const std::string &name)
{
    if (name.empty())
        return std::string(kind) + " " + std::to_string(index);
    return std::string(kind) + " \"" + name + "\"";
}

float finite_float(double value, const std::string &owner, const char *property)
{
    const float rounded = static_cast<float>(value);
    if (!std::isfinite(rounded))
        fail_import(STATUS_FORMAT, "%s: %s is %g, not a finite number", owner.c_str(), property,
                    value);
    return rounded;
}

const tinygltf::Value *find_extension(const tinygltf::ExtensionMap &extensions, const char *name)
{
    const auto found = extensions.find(name);
    return found != extensions.end() ? &found->second : nullptr;
}

double number_member(const tinygltf::Value &object, const char *name, double fallback,
                     const std::string &owner)
{
    if (!object.Has(name))
        return fallback;
    const tinygltf::Value &value = object.Get(std::string(name));
    if (!value.IsNumber())
        fail_import(STATUS_FORMAT, "%s: %s is not a number", owner.c_str(), name);
    return value.GetNumberAsDouble();
}

int index_member(const tinygltf::Value &object, const char *name, const std::string &owner)
{
    if (!object.Has(name))
        return -1;
    const tinygltf::Value &value = object.Get(std::string(name));
    if (!value.IsInt() || value.GetNumberAsInt() < 0)
        fail_import(STATUS_FORMAT, "%s: %s is not an index", owner.c_str(), name);
    return value.GetNumberAsInt();
}

void numbers_member(const tinygltf::Value &object, const char *name, float *out, size_t count,
                    const std::string &owner)
{
    if (!object.Has(name))
        return;
    const tinygltf::Value &array = object.Get(std::string(name));
    if (!array.IsArray() || array.ArrayLen() != count)
        fail_import(STATUS_FORMAT, "%s: %s is not an array of %zu numbers", owner.c_str(), name,
                    count);
    for (size_t i = 0; i < count; i++) {
        const tinygltf::Value &value = array.Get(static_cast<int>(i));
        if (!value.IsNumber())
            fail_import(STATUS_FORMAT, "%s: %s is not an array of %zu numbers", owner.c_str(), name,
                        count);
        out[i] = finite_float(value.GetNumberAsDouble(), owner, name);
    }
}
