#pragma once

#include <string_view>

#include <nlohmann/json.hpp>

#include "core/base/result.h"

namespace camrig::camera {

inline constexpr std::size_t max_yaml_bytes = 256 * 1024;

/// Parses untrusted YAML (or JSON, which is YAML; or the almost-YAML of OpenCV's FileStorage with its "%YAML:1.0" line)
/// into objects, arrays and *strings*: YAML decides what a scalar is only when it is read, so scalars stay text, and an
/// empty one is null. Refuses text over 256 KiB, nesting over 16, more than 20000 values (aliases count every
/// time they are used), duplicate keys and keys that are no scalars. Errors name the line, or the path of the key.
/// No exception of the YAML library gets out.
Result<nlohmann::json> parse_yaml(std::string_view text);

}  // namespace camrig::camera
