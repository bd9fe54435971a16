#pragma once

#include <span>
#include <string_view>

namespace camrig::world::gltf {

/// The two parts of a glTF file; views into the bytes given to split_container().
struct Container {
    std::string_view json;
    std::span<const std::byte> binary{};  ///< the BIN chunk; empty for .gltf
    bool has_binary = false;
    bool is_binary = false;  ///< .glb
};

/// Tells .glb (magic) from .gltf and checks header and chunks of the former (glTF 2.0, 4.4). Throws Failure.
Container split_container(std::span<const std::byte> bytes);

}  // namespace camrig::world::gltf
