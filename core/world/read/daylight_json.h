#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "core/base/field_table.h"
#include "core/base/result.h"
#include "core/world/daylight_spec.h"

namespace camrig::world {

FieldTable<DaylightSpec> fields_of(std::type_identity<DaylightSpec>);

/// The sun is either at angles or over a place at a time.
Result<DaylightSpec> read_daylight(const nlohmann::json& value, const std::string& path);

}  // namespace camrig::world
