#pragma once

#include "core/base/kind.h"
#include "core/world/snapshot.h"

namespace camrig::world {

FieldTable<FogSpec> fields_of(std::type_identity<FogSpec>);
Result<FogSpec> read_fog(const nlohmann::json& value, const std::string& path);

/// The `environment` of a scene file.
FieldTable<Environment> fields_of(std::type_identity<Environment>);
/// Its `lights`, by their `type`.
const std::vector<Kind<Light>>& light_kinds();

}  // namespace camrig::world
