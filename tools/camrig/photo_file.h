#pragma once

#include <filesystem>

#include "core/base/result.h"
#include "core/world/model.h"

namespace camrig::cli {

/// A photo, PNG or JPEG, at most 16384 pixels a side.
Result<world::Image> read_photo(const std::filesystem::path& file);

}  // namespace camrig::cli
