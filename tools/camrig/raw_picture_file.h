#pragma once

#include <filesystem>
#include <vector>

#include "core/sensor/photon_transfer.h"

namespace camrig::cli {

/// The pictures of a file: one of a grey PNG of 8 or 16 bits, one or several of a NumPy array (.npy) of uint8 or
/// uint16, of shape (height, width) or (pictures, height, width), in C order. Errors name the file.
Result<std::vector<sensor::RawPicture>> read_raw_pictures(const std::filesystem::path& file);

}  // namespace camrig::cli
