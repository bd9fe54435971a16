#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <string>

#include <sys/types.h>

#include "core/base/result.h"

namespace camrig {

/// Writes a file anew. A reader of it sees the old content or the new one, never half of one. `mode`: who may read and
/// write it, less what the process's umask takes away.
Result<void> write_atomically(const std::filesystem::path& file, std::span<const std::byte> bytes, mode_t mode = 0666);
/// Writes all of it to an open file; write(2) may take a part. `name` is how the error names the file.
Result<void> write_all(int fd, std::span<const std::byte> bytes, const std::string& name);

}  // namespace camrig
