#pragma once

#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

/// Scene files as text that a command changes: all keys stay in their order.
namespace camrig::cli {

using OrderedJson = nlohmann::ordered_json;

Result<OrderedJson> read_scene_text(const std::filesystem::path& file);
Result<void> write_json_text(const std::filesystem::path& file, const OrderedJson& value);

/// The camera of this name in the scene; a new one at the end of its list if `may_add`.
Result<OrderedJson*> camera_of(OrderedJson& scene, const std::string& name, bool may_add);

}  // namespace camrig::cli
