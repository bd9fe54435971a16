#pragma once

#include <optional>
#include <string_view>

#include <nlohmann/json.hpp>

#include "core/base/image_size.h"
#include "core/base/json_reader.h"
#include "core/base/rate.h"

/// Sizes of pictures and frame rates in JSON: [width, height], and a number or "num/den".
namespace camrig {

/// Nothing: the key is not there, or its value is none, and the error remembered. Sides from 0 to 1e6, larger ones as
/// 1e6: the exact range is its user's to check.
std::optional<ImageSize> read_size(JsonReader& reader, std::string_view key);
std::optional<Rate> read_rate(JsonReader& reader, std::string_view key);
nlohmann::json size_to_json(ImageSize size);
nlohmann::json rate_to_json(const Rate& rate);

}  // namespace camrig
