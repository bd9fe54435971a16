#pragma once

#include <string>
#include <string_view>

#include <glm/glm.hpp>
#include <glm/gtc/quaternion.hpp>

#include "core/base/json_reader.h"

/// Values that several parts of a scene file, and commands, share. Each remembers its error in the reader.
namespace camrig {

inline constexpr std::size_t max_scene_name_bytes = 64;
inline constexpr double max_speed_m_s = 1000.0;

/// "objects[3]"
std::string item_path(std::string_view list, std::size_t index);

/// Names of scene things are free text that stays readable in messages and truth files.
bool is_scene_name(std::string_view name);
void required_name(JsonReader& reader, std::string_view key, std::string& out);
void optional_name(JsonReader& reader, std::string_view key, std::string& out);

void optional_in_range(JsonReader& reader, std::string_view key, double& out, double low, double high);
void optional_color(JsonReader& reader, std::string_view key, glm::vec3& out);

/// Whether the key was there.
bool read_vector(JsonReader& reader, std::string_view key, glm::dvec3& out);
/// [x, y] or [x, y, z]; the z that is not given stays as it is. False, and the reader is left alone: neither.
bool read_point(const nlohmann::json& value, glm::dvec3& out);
/// "yaw_deg" (about z, counter-clockwise) or "orientation": [x, y, z, w]. Whether one of them was there.
bool read_orientation(JsonReader& reader, glm::dquat& out);

}  // namespace camrig
