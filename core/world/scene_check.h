#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "core/base/error_list.h"
#include "core/world/scene.h"

namespace camrig::world {

/// What is wrong with a scene.
struct SceneCheck {
    std::filesystem::path file;       ///< that was read
    std::vector<PlacedError> errors;  ///< in the order of reading; empty: the scene is good
    std::size_t left_out = 0;         ///< errors beyond ErrorList::max_errors
    SceneRef scene;                   ///< when it is good
};

/// Reads a scene as load_scene() does, but on after errors. What refers to something that could not be read is not
/// blamed for that; errors of a kind that only shows when others are mended may be left.
SceneCheck check_scene(const std::filesystem::path& scene);

}  // namespace camrig::world
