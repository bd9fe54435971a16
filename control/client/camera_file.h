#pragma once

#include <cstddef>
#include <filesystem>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig::client {

/// Cameras from a file, as a list of parameters of camera.create: the file holds a camera (as camera.get gives it), a
/// list of at most 1024 of them, or {"cameras": [...]}. Errors name the file.
Result<nlohmann::json> read_camera_file(const std::filesystem::path& file);

/// "FILE: cameras[2]: " and, when cameras before it were made, a word on them: the place of an error.
std::string camera_in_file(const std::filesystem::path& file, std::size_t index);

}  // namespace camrig::client
