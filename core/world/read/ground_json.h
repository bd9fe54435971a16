#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/world/scene.h"

namespace camrig {

inline constexpr std::size_t max_route_points = 2000;
inline constexpr std::size_t max_area_points = 2000;
inline constexpr std::size_t max_area_obstacles = 1000;
inline constexpr std::size_t max_area_corners = 4000;

/// One of the `routes`, `areas` and `places` of a scene file; errors carry the JSON path.
Result<Route> read_route(const nlohmann::json& value, const std::string& path);
Result<Area> read_area(const nlohmann::json& value, const std::string& path);
Result<Place> read_place(const nlohmann::json& value, const std::string& path);

}  // namespace camrig
