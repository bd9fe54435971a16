#pragma once

#include <filesystem>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/world/read/model_json.h"
#include "core/world/scene.h"

namespace camrig::world {

/// What one scene file may hold.
inline constexpr std::size_t max_scene_bytes = std::size_t{64} << 20;
inline constexpr std::size_t max_scene_models = 1000;
inline constexpr std::size_t max_scene_objects = 20000;
inline constexpr std::size_t max_scene_actors = 5000;
inline constexpr std::size_t max_scene_lights = 256;
inline constexpr std::size_t max_scene_routes = 1000;
inline constexpr std::size_t max_scene_areas = 1000;
inline constexpr std::size_t max_scene_places = 1000;
inline constexpr std::size_t max_scene_cameras = 256;
inline constexpr std::size_t max_scene_events = 1000;
inline constexpr TimeNs min_step_ns = ns_per_ms;
inline constexpr TimeNs max_step_ns = 100 * ns_per_ms;

/// The keys of a scene file.
FieldTable<Scene> fields_of(std::type_identity<Scene>);

/// Reads a scene document (docs/scene-format.md). `folder` is where its model files are; errors carry the JSON path.
Result<Scene> read_scene(const nlohmann::json& document, const std::filesystem::path& folder,
                         const ModelSource& models);

}  // namespace camrig::world
