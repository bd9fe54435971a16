#include "core/world/gltf/accessor_reader.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace camrig::world::gltf {
namespace {

/// One component of a file's type, converted.
template <typename In, typename Out>
Out convert(const std::byte* from, bool normalised) {
    In value;
    std::memcpy(&value, from, sizeof value);
    if constexpr (std::is_floating_point_v<Out> && std::is_integral_v<In>) {
        if (!normalised) return static_cast<Out>(value);
        const auto scaled = static_cast<Out>(value) / static_cast<Out>(std::numeric_limits<In>::max());
        return std::max(scaled, Out{-1});
    } else {
        return static_cast<Out>(value);
    }
}

template <typename In, typename Out>
void copy_elements(const std::byte* from, std::size_t stride, std::size_t count, int width, bool normalised, Out* to) {
    for (std::size_t i = 0; i < count; ++i, from += stride)
        for (int c = 0; c < width; ++c)
            *to++ = convert<In, Out>(from + static_cast<std::size_t>(c) * sizeof(In), normalised);
}

template <typename Out>
void copy_any(int type, const std::byte* from, std::size_t stride, std::size_t count, int width, bool normalised,
              Out* to) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return copy_elements<std::int8_t>(from, stride, count, width, normalised, to);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return copy_elements<std::uint8_t>(from, stride, count, width, normalised, to);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return copy_elements<std::int16_t>(from, stride, count, width, normalised, to);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return copy_elements<std::uint16_t>(from, stride, count, width, normalised, to);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return copy_elements<std::uint32_t>(from, stride, count, width, normalised, to);
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            if constexpr (std::is_floating_point_v<Out>)
                return copy_elements<float>(from, stride, count, width, normalised, to);
            break;
        default:
            break;
    }
    CHECK(false && "component type was checked by layout()");
}

/// The bit of a component type in the mask of allowed ones; 0 for types that no use allows.
unsigned component_bit(int type, bool normalised) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return normalised ? int8_normalised : int8;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return normalised ? uint8_normalised : uint8;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return normalised ? int16_normalised : int16;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return normalised ? uint16_normalised : uint16;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return normalised ? 0u : uint32;
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return float32;
        default:
            return 0;
    }
}

std::size_t component_size(int type) {
    return static_cast<std::size_t>(tinygltf::GetComponentSizeInBytes(static_cast<std::uint32_t>(type)));
}

/// offset + stride * (count - 1) + size <= limit, where nothing can overflow: count <= 2^26, stride <= 252.
bool fits(std::size_t offset, std::size_t stride, std::size_t count, std::size_t size, std::size_t limit) {
    return count == 0 || (offset <= limit && stride * (count - 1) + size <= limit - offset);
}

}  // namespace

struct AccessorReader::Layout {
    const tinygltf::Accessor* accessor = nullptr;
    std::size_t element_size = 0;
    std::size_t stride = 0;
    std::span<const std::byte> bytes{};  ///< from the first element on; empty: all zero
};

const tinygltf::Accessor& AccessorReader::get(std::int64_t accessor, std::string_view place) const {
    const auto& all = document_.gltf.accessors;
    require(accessor >= 0 && accessor < std::ssize(all), place,
            "accessor " + std::to_string(accessor) + " of " + std::to_string(all.size()));
    return all[static_cast<std::size_t>(accessor)];
}

std::size_t AccessorReader::count(std::int64_t accessor, std::string_view place) const {
    return get(accessor, place).count;
}

int AccessorReader::width(std::int64_t accessor, std::string_view place) const {
    return tinygltf::GetNumComponentsInType(static_cast<std::uint32_t>(get(accessor, place).type));
}

AccessorReader::Layout AccessorReader::layout(std::int64_t index, int width, unsigned allowed,
                                              std::string_view place) const {
    const tinygltf::Accessor& accessor = get(index, place);
    require(accessor.count >= 1 && accessor.count <= max_indices, place,
            std::to_string(accessor.count) + " elements; 1 to " + std::to_string(max_indices) + " are read");
    const int own_width = this->width(index, place);
    require(own_width == width, place,
            std::to_string(own_width) + " components per element instead of " + std::to_string(width));
    require((component_bit(accessor.componentType, accessor.normalized) & allowed) != 0, place,
            "component type " + std::to_string(accessor.componentType) + (accessor.normalized ? " (normalized)" : "") +
                " is not allowed here");
    Layout result{.accessor = &accessor};
    result.element_size = component_size(accessor.componentType) * static_cast<std::size_t>(width);
    result.stride = result.element_size;
    if (accessor.bufferView < 0) return result;

    const auto view = document_.view(accessor.bufferView, place);
    const std::size_t given = document_.gltf.bufferViews[static_cast<std::size_t>(accessor.bufferView)].byteStride;
    if (given != 0) result.stride = given;
    require(result.stride >= result.element_size, place,
            "byteStride " + std::to_string(given) + " is less than an element's " +
                std::to_string(result.element_size) + " bytes");
    require(fits(accessor.byteOffset, result.stride, accessor.count, result.element_size, view.size()), place,
            std::to_string(accessor.count) + " elements do not fit into a buffer view of " +
                std::to_string(view.size()) + " bytes");
    result.bytes = view.subspan(accessor.byteOffset);
    return result;
}

template <typename Out>
std::vector<Out> AccessorReader::read(std::int64_t index, int width, unsigned allowed, std::string_view place) const {
    const Layout from = layout(index, width, allowed, place);
    const tinygltf::Accessor& accessor = *from.accessor;
    const auto components = static_cast<std::size_t>(width);
    budget_.take(accessor.count * components * sizeof(Out), place);
    std::vector<Out> out(accessor.count * components);
    if (!from.bytes.empty())
        copy_any(accessor.componentType, from.bytes.data(), from.stride, accessor.count, width, accessor.normalized,
                 out.data());
    if (!accessor.sparse.isSparse) return out;

    const auto& sparse = accessor.sparse;
    const auto count = static_cast<std::size_t>(std::max(sparse.count, 0));
    require(count >= 1 && count <= accessor.count, place, "sparse: more elements than the accessor has");
    require(sparse.indices.byteOffset >= 0 && sparse.values.byteOffset >= 0, place, "sparse: negative byteOffset");
    const unsigned bit = component_bit(sparse.indices.componentType, false);
    require((bit & (uint8 | uint16 | uint32)) != 0, place, "sparse.indices: component type is not unsigned");
    const auto index_size = component_size(sparse.indices.componentType);
    const auto index_view = document_.view(sparse.indices.bufferView, place);
    const auto value_view = document_.view(sparse.values.bufferView, place);
    const auto index_offset = static_cast<std::size_t>(sparse.indices.byteOffset);
    const auto value_offset = static_cast<std::size_t>(sparse.values.byteOffset);
    require(fits(index_offset, index_size, count, index_size, index_view.size()) &&
                fits(value_offset, from.element_size, count, from.element_size, value_view.size()),
            place, "sparse: indices or values do not fit into their buffer view");
    budget_.take(count * (sizeof(std::uint32_t) + components * sizeof(Out)), place);
    std::vector<std::uint32_t> places(count);
    std::vector<Out> values(count * components);
    copy_any(sparse.indices.componentType, index_view.data() + index_offset, index_size, count, 1, false,
             places.data());
    copy_any(accessor.componentType, value_view.data() + value_offset, from.element_size, count, width,
             accessor.normalized, values.data());
    for (std::size_t i = 0; i < count; ++i) {
        require(places[i] < accessor.count && (i == 0 || places[i] > places[i - 1]), place,
                "sparse.indices: not rising or out of range");
        std::copy_n(values.data() + i * components, components, out.data() + places[i] * components);
    }
    return out;
}

std::vector<float> AccessorReader::floats(std::int64_t accessor, int width, unsigned allowed,
                                          std::string_view place) const {
    auto out = read<float>(accessor, width, allowed, place);
    for (const float value : out) require(std::abs(value) <= max_value, place, "a number is not finite or over 1e10");
    return out;
}

std::vector<std::uint32_t> AccessorReader::integers(std::int64_t accessor, int width, unsigned allowed,
                                                    std::string_view place) const {
    CHECK((allowed & ~unsigned{uint8 | uint16 | uint32}) == 0);
    return read<std::uint32_t>(accessor, width, allowed, place);
}

}  // namespace camrig::world::gltf
