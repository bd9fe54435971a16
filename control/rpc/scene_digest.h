#pragma once

#include <cstdint>
#include <filesystem>

#include "core/base/result.h"

namespace camrig::control {

struct SceneDigest {
    std::uint64_t value = 0;
    std::size_t files = 0;
};

/// A hash of the bytes of a scene file and of every file that a text in it names, from its own folder: models,
/// pictures, and what those of .gltf name; also of those that come with the program ("camrig:NAME"). Where the files
/// lie does not matter. not_found: the scene cannot be read.
Result<SceneDigest> digest_of_scene(const std::filesystem::path& scene);

}  // namespace camrig::control
