#pragma once

#include <filesystem>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig::world {

/// The file of a scene, as JSON.
Result<nlohmann::json> read_scene_document(const std::filesystem::path& file);

/// A scene file that only says how it differs from another (`base`).
struct BasedScene {
    nlohmann::json document;                     ///< all of it, without `base`
    std::vector<std::filesystem::path> bases{};  ///< the files it stands on, nearest first
};

/// Puts what `document`, of `file`, says over what its base says: objects key by key, null takes a key away (RFC 7396);
/// lists of things with names thing by thing, new ones at the end; all else is replaced. Errors begin with "base".
Result<BasedScene> on_its_base(nlohmann::json document, const std::filesystem::path& file);

}  // namespace camrig::world
