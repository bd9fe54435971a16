#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "core/base/kind.h"
#include "core/base/result.h"
#include "core/world/behaviour_spec.h"

namespace camrig::world {

inline constexpr std::size_t max_sequence_steps = 64;
inline constexpr int max_sequence_depth = 4;

/// The behaviours by their `type`, in the order of BehaviourSpec.
const std::vector<Kind<BehaviourSpec>>& behaviour_kinds();
/// Reads a behaviour; errors carry the JSON path. Names are not looked up here: check_actor() does that.
Result<BehaviourSpec> read_behaviour(const nlohmann::json& value, const std::string& path);

}  // namespace camrig::world
