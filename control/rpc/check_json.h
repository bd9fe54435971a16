#pragma once

#include <nlohmann/json.hpp>

#include "core/world/scene_check.h"

namespace camrig {

/// What scene.check answers, and `camrig check --json`.
nlohmann::json to_json(const SceneCheck& check);

}  // namespace camrig
