#pragma once

#include <string>

#include "core/base/field_of.h"
#include "core/world/scene.h"

namespace camrig::world {

inline constexpr std::size_t max_route_points = 2000;
inline constexpr std::size_t max_area_points = 2000;
inline constexpr std::size_t max_area_obstacles = 1000;
inline constexpr std::size_t max_area_corners = 4000;

FieldTable<Route> fields_of(std::type_identity<Route>);
FieldTable<Area> fields_of(std::type_identity<Area>);
FieldTable<Place> fields_of(std::type_identity<Place>);

/// One of the `routes` and `areas` of a scene file; errors carry the JSON path.
Result<Route> read_route(const nlohmann::json& value, const std::string& path);
Result<Area> read_area(const nlohmann::json& value, const std::string& path);

}  // namespace camrig::world
