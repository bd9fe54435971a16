#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig::view {

/// The cameras of camera.list as a cameras file: {"cameras": [...]}, which `camrig camera create --file` takes as it is
/// and whose list is the `cameras` of a scene file. `without`: the view's own camera. What is derived or says how a
/// camera lives is left out.
nlohmann::json arrangement_of(const nlohmann::json& camera_list, const std::string& without);

Result<void> write_arrangement(const std::filesystem::path& file, const nlohmann::json& arrangement);

/// "lobby" -> "lobby_2", "lobby_2" -> "lobby_3": the next name of at most 24 characters that is not taken.
std::string free_name(const std::string& like, const std::vector<std::string>& taken);

}  // namespace camrig::view
