#pragma once

#include <cmath>
#include <cstdint>
#include <span>

#include "core/base/image_size.h"

namespace camrig::photo {

/// A decoded photo, 8 bit sRGB, rows from the top. Not owned.
struct Picture {
    ImageSize size;
    std::span<const std::uint8_t> rgba;

    int code(int x, int y, int channel) const { return rgba[std::size_t(4 * (y * size.width + x) + channel)]; }
};

/// Pixels from `x`, `y` on.
struct Region {
    int x = 0, y = 0, width = 0, height = 0;
};

/// Linear light of a code, 0 to 1 (IEC 61966-2-1).
inline double linear_of(double code) {
    const double v = code / 255.0;
    return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4);
}

}  // namespace camrig::photo
