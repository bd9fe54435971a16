#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "core/world/gltf/document.h"

namespace camrig::world::gltf {

/// Component types an accessor may have for one use; bits of a mask.
enum Components : unsigned {
    float32 = 1,
    uint8 = 2,
    uint16 = 4,
    uint32 = 8,
    uint8_normalised = 16,
    uint16_normalised = 32,
    int8_normalised = 64,
    int16_normalised = 128,
    int8 = 256,
    int16 = 512,
};

/// Reads accessors (glTF 2.0, 3.6.2) with everything checked: indices, component types, offset + stride * count within
/// the buffer view in 64 bits, sparse indices rising and in range, numbers finite. Throws Failure.
class AccessorReader {
public:
    AccessorReader(const Document& document, Budget& budget) : document_(document), budget_(budget) {}

    /// Number of elements; the index is checked.
    std::size_t count(std::int64_t accessor, std::string_view place) const;
    /// Number of components per element.
    int width(std::int64_t accessor, std::string_view place) const;
    /// All components as floats, integers converted (glTF 2.0, 3.11 for normalised ones).
    std::vector<float> floats(std::int64_t accessor, int width, unsigned allowed, std::string_view place) const;
    /// Unsigned integers.
    std::vector<std::uint32_t> integers(std::int64_t accessor, int width, unsigned allowed,
                                        std::string_view place) const;

private:
    struct Layout;
    const tinygltf::Accessor& get(std::int64_t accessor, std::string_view place) const;
    Layout layout(std::int64_t accessor, int width, unsigned allowed, std::string_view place) const;
    template <typename Out>
    std::vector<Out> read(std::int64_t accessor, int width, unsigned allowed, std::string_view place) const;

    const Document& document_;
    Budget& budget_;
};

}  // namespace camrig::world::gltf
