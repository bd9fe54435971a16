#pragma once

#include <compare>
#include <cstdint>
#include <string>

namespace camrig {

/// Width and height in pixels, always in this order.
struct ImageSize {
    int width = 0;
    int height = 0;

    std::int64_t pixels() const { return std::int64_t{width} * height; }
    std::string to_string() const { return std::to_string(width) + "x" + std::to_string(height); }
    friend auto operator<=>(const ImageSize&, const ImageSize&) = default;
};

/// Smallest and largest picture a camera can have (contract).
inline constexpr ImageSize min_image_size{16, 16};
inline constexpr ImageSize max_image_size{8192, 8192};

}  // namespace camrig
