#pragma once

#include <string>
#include <string_view>
#include <utility>

#include "core/base/result.h"

namespace camrig::world::gltf {

/// Ends the reading of a glTF file. Thrown and caught inside core/world/gltf only: load_model() turns it into a Result,
/// so that the readers of accessors, meshes and nodes need no error branch on every line.
struct Failure {
    Error error;
};

/// "meshes[0].primitives[2].indices: value 7 of 6 vertices"
[[noreturn]] inline void fail(std::string_view place, std::string_view what,
                              ErrorKind kind = ErrorKind::invalid_argument) {
    throw Failure{Error{kind, place.empty() ? std::string(what) : std::string(place) + ": " + std::string(what)}};
}

inline void require(bool condition, std::string_view place, std::string_view what) {
    if (!condition) [[unlikely]]
        fail(place, what);
}

/// "nodes" 3 -> "nodes[3]"
inline std::string item(std::string_view list, std::size_t index) {
    return std::string(list) + "[" + std::to_string(index) + "]";
}

}  // namespace camrig::world::gltf
