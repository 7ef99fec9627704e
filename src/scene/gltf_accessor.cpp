#include "scene/gltf_accessor.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include "scene/gltf_buffer.hpp"

// 31-bit indices reach no further.
static const size_t MAX_COUNT = ((size_t)1 << 31) - 1;

// Most elements of an accessor that has no data of its own and so costs the file nothing.
static const size_t MAX_EMPTY_COUNT = (size_t)1 << 26;

// Where the elements of an accessor stand.
struct element_layout {
    const uint8_t *first; // nullptr: all are zero
    size_t stride;        // bytes from one to the next
    size_t count;
    int components; // numbers in each
};

const tinygltf::Accessor &find_accessor(const import_context &context, int index,
                                        const std::string &owner)
{
    if (index < 0 || static_cast<size_t>(index) >= context.model.accessors.size())
        fail_import(STATUS_FORMAT, "%s: there is no accessor %d", owner.c_str(), index);
    return context.model.accessors[static_cast<size_t>(index)];
}

int component_count(const tinygltf::Accessor &accessor)
{
    return tinygltf::GetNumComponentsInType(static_cast<uint32_t>(accessor.type));
}

// Bytes of one number; fails for types that glTF does not have.
static size_t component_size(int type, const std::string &owner)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        return 1;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        return 2;
    case TINYGLTF_COMPONENT_TYPE_INT:
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        return 4;
    case TINYGLTF_COMPONENT_TYPE_DOUBLE:
        return 8;
    default:
        fail_import(STATUS_FORMAT, "%s: component type %d does not exist", owner.c_str(), type);
    }
}

// Finds `count` elements in a buffer view and checks that all of them lie within.
static element_layout find_elements(import_context &context, int view, size_t offset, size_t stride,
                                    size_t count, size_t element_size, const std::string &owner)
{
    const byte_span bytes = view_bytes(context, view, owner);
    if (stride == 0)
        stride = element_size;
    if (stride < element_size)
        fail_import(STATUS_FORMAT, "%s: byteStride %zu is less than an element's %zu bytes",
                    owner.c_str(), stride, element_size);
    if (count > MAX_COUNT)
        fail_import(STATUS_LIMIT, "%s: %zu elements are too many", owner.c_str(), count);
    const size_t needed = count == 0 ? 0 : (count - 1) * stride + element_size;
    if (offset > bytes.size || needed > bytes.size - offset)
        fail_import(STATUS_FORMAT,
                    "%s: %zu elements of %zu bytes from offset %zu leave buffer view %d of %zu "
                    "bytes",
                    owner.c_str(), count, element_size, offset, view, bytes.size);
    return {bytes.data + offset, stride, count, 0};
}

// Checks an accessor and finds its elements, those of sparse ones aside.
static element_layout layout_of(import_context &context, const tinygltf::Accessor &accessor,
                                int components, const std::string &owner)
{
    const size_t size = component_size(accessor.componentType, owner);
    if (component_count(accessor) != components)
        fail_import(STATUS_FORMAT, "%s: an element has %d numbers, not %d", owner.c_str(),
                    component_count(accessor), components);
    element_layout layout = {nullptr, 0, accessor.count, components};
    if (accessor.bufferView >= 0) {
        const size_t view = static_cast<size_t>(accessor.bufferView);
        const size_t stride = view < context.model.bufferViews.size()
                                  ? context.model.bufferViews[view].byteStride
                                  : 0;
        layout = find_elements(context, accessor.bufferView, accessor.byteOffset, stride,
                               accessor.count, size * static_cast<size_t>(components), owner);
        layout.components = components;
    } else if (accessor.count > MAX_EMPTY_COUNT) {
        fail_import(STATUS_LIMIT, "%s: %zu elements without a buffer view are too many",
                    owner.c_str(), accessor.count);
    }
    return layout;
}

size_t checked_count(import_context &context, int index, int components, const std::string &owner)
{
    return layout_of(context, find_accessor(context, index, owner), components, owner).count;
}

// Copies numbers of one type; `scale` and `lowest` normalise, or are 1 and minus infinity.
template <typename FROM, typename TO>
static void copy_numbers(const element_layout &from, double scale, double lowest, TO *out)
{
    const size_t components = static_cast<size_t>(from.components);
    if (std::is_same<FROM, TO>::value && from.stride == components * sizeof(FROM)) {
        memcpy(out, from.first, from.count * from.stride);
        return;
    }
    for (size_t i = 0; i < from.count; i++) {
        const uint8_t *const element = from.first + i * from.stride;
        for (size_t c = 0; c < components; c++) {
            FROM value;
            memcpy(&value, element + c * sizeof(FROM), sizeof(FROM));
            if (std::is_integral<TO>::value) {
                *out++ = static_cast<TO>(value);
            } else {
                const double scaled = static_cast<double>(value) * scale;
                *out++ = static_cast<TO>(scaled < lowest ? lowest : scaled);
            }
        }
    }
}

// Copies whole numbers to float, normalised (glTF 2.0, section 3.6.2.2) or as they are.
template <typename FROM>
static void copy_scaled(const element_layout &from, bool normalized, float *out)
{
    const double highest = static_cast<double>(std::numeric_limits<FROM>::max());
    copy_numbers<FROM, float>(from, normalized ? 1.0 / highest : 1.0,
                              normalized ? -1.0 : -std::numeric_limits<double>::infinity(), out);
}

static void copy_as_float(const element_layout &from, int type, bool normalized, float *out)
{
    const double none = -std::numeric_limits<double>::infinity();
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_BYTE:
        copy_scaled<int8_t>(from, normalized, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        copy_scaled<uint8_t>(from, normalized, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_SHORT:
        copy_scaled<int16_t>(from, normalized, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        copy_scaled<uint16_t>(from, normalized, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_INT:
        copy_scaled<int32_t>(from, normalized, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        copy_scaled<uint32_t>(from, normalized, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_FLOAT:
        copy_numbers<float, float>(from, 1.0, none, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_DOUBLE:
        copy_numbers<double, float>(from, 1.0, none, out);
        break;
    }
}

static void copy_as_integer(const element_layout &from, int type, const std::string &owner,
                            uint32_t *out)
{
    switch (type) {
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
        copy_numbers<uint8_t, uint32_t>(from, 1.0, 0.0, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
        copy_numbers<uint16_t, uint32_t>(from, 1.0, 0.0, out);
        break;
    case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        copy_numbers<uint32_t, uint32_t>(from, 1.0, 0.0, out);
        break;
    default:
        fail_import(STATUS_FORMAT, "%s: component type %d is no unsigned whole number",
                    owner.c_str(), type);
    }
}

// Where a sparse accessor's replacements go, and where they stand.
struct sparse_part {
    std::vector<uint32_t> targets; // ascending, below the accessor's count
    element_layout values;         // [targets.size()]
};

static sparse_part read_sparse(import_context &context, const tinygltf::Accessor &accessor,
                               int components, const std::string &owner)
{
    const auto &sparse = accessor.sparse;
    if (sparse.count < 0 || static_cast<size_t>(sparse.count) > accessor.count ||
        sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        fail_import(STATUS_FORMAT, "%s: %d sparse elements in an accessor of %zu", owner.c_str(),
                    sparse.count, accessor.count);
    const size_t count = static_cast<size_t>(sparse.count);
    const size_t index_size = component_size(sparse.indices.componentType, owner);
    const size_t size = component_size(accessor.componentType, owner);

    element_layout indices =
        find_elements(context, sparse.indices.bufferView,
                      static_cast<size_t>(sparse.indices.byteOffset), 0, count, index_size, owner);
    indices.components = 1;
    sparse_part part;
    part.targets.resize(count);
    copy_as_integer(indices, sparse.indices.componentType, owner, part.targets.data());
    for (size_t i = 0; i < count; i++) {
        if (part.targets[i] >= accessor.count || (i > 0 && part.targets[i] <= part.targets[i - 1]))
            fail_import(STATUS_FORMAT, "%s: sparse indices are not ascending below %zu",
                        owner.c_str(), accessor.count);
    }
    part.values = find_elements(context, sparse.values.bufferView,
                                static_cast<size_t>(sparse.values.byteOffset), 0, count,
                                size * static_cast<size_t>(components), owner);
    part.values.components = components;
    return part;
}

// Puts the values of a sparse accessor in their places.
template <typename T>
static void scatter(const sparse_part &part, const std::vector<T> &values, T *out)
{
    const size_t components = static_cast<size_t>(part.values.components);
    for (size_t i = 0; i < part.targets.size(); i++)
        memcpy(out + part.targets[i] * components, values.data() + i * components,
               components * sizeof(T));
}

void read_floats(import_context &context, int index, int components, bool force_normalized,
                 const std::string &owner, float *out)
{
    const tinygltf::Accessor &accessor = find_accessor(context, index, owner);
    const bool normalized = accessor.normalized || force_normalized;
    const element_layout layout = layout_of(context, accessor, components, owner);
    const size_t number_count = layout.count * static_cast<size_t>(components);
    if (layout.first != nullptr)
        copy_as_float(layout, accessor.componentType, normalized, out);
    else
        memset(out, 0, number_count * sizeof(float));
    if (accessor.sparse.isSparse) {
        const sparse_part part = read_sparse(context, accessor, components, owner);
        std::vector<float> values(part.targets.size() * static_cast<size_t>(components));
        copy_as_float(part.values, accessor.componentType, normalized, values.data());
        scatter(part, values, out);
    }

    // x * 0 is 0 for finite x only, and the sum keeps any NaN; a loop without branches.
    float check = 0.0f;
    for (size_t i = 0; i < number_count; i++)
        check += out[i] * 0.0f;
    if (check == 0.0f)
        return;
    for (size_t i = 0; i < number_count; i++) {
        if (!std::isfinite(out[i]))
            fail_import(STATUS_FORMAT, "%s: element %zu of accessor %d is not finite",
                        owner.c_str(), i / static_cast<size_t>(components), index);
    }
}

void read_integers(import_context &context, int index, int components, const std::string &owner,
                   uint32_t *out)
{
    const tinygltf::Accessor &accessor = find_accessor(context, index, owner);
    const element_layout layout = layout_of(context, accessor, components, owner);
    if (layout.first != nullptr)
        copy_as_integer(layout, accessor.componentType, owner, out);
    else
        memset(out, 0, layout.count * static_cast<size_t>(components) * sizeof(uint32_t));
    if (accessor.sparse.isSparse) {
        const sparse_part part = read_sparse(context, accessor, components, owner);
        std::vector<uint32_t> values(part.targets.size() * static_cast<size_t>(components));
        copy_as_integer(part.values, accessor.componentType, owner, values.data());
        scatter(part, values, out);
    }
}
