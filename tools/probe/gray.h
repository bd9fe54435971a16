#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/image_size.h"

namespace camrig::probe {

/// Brightness of a picture in a V4L2 format, one byte a pixel (green stands for it in RGB formats). False: a format
/// this does not know, or too few bytes. `row_bytes` as the driver says (0: no padding).
bool gray_from_raw(std::uint32_t fourcc, std::span<const std::byte> bytes, ImageSize size, std::size_t row_bytes,
                   std::vector<std::byte>& gray);

/// The same of a JPEG; sets the size. False: broken or incomplete.
bool gray_from_jpeg(std::span<const std::byte> jpeg, ImageSize& size, std::vector<std::byte>& gray);

}  // namespace camrig::probe
