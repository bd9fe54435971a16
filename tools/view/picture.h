#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/result.h"

namespace camrig::view {

/// RGBA, rows from the top without padding.
struct Picture {
    int width = 0;
    int height = 0;
    std::vector<std::uint8_t> rgba = {};
};

/// At most 8192x8192. With `most_width`, made smaller while it is decoded (by eighths), which costs less than the whole
/// picture.
Result<Picture> decode_jpeg(std::span<const std::byte> bytes, int most_width = 1 << 14);

}  // namespace camrig::view
