#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/world/snapshot.h"

namespace camrig {

/// The `environment` and one of the `lights` of a scene file; errors carry the JSON path.
Result<Environment> read_environment(const nlohmann::json& value, std::string path);
Result<Light> read_light(const nlohmann::json& value, std::string path);

}  // namespace camrig
