#pragma once

#include <cstddef>
#include <filesystem>
#include <span>

#include "core/base/result.h"

namespace camrig {

/// Writes a file anew. A reader of it sees the old content or the new one, never half of one.
Result<void> write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes);

}  // namespace camrig
