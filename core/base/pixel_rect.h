#pragma once

#include <cstdint>

namespace camrig {

/// Pixels x0 <= x < x1, y0 <= y < y1.
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
    int width() const { return x1 - x0; }
    int height() const { return y1 - y0; }
    std::int64_t area() const { return std::int64_t{width()} * height(); }
    bool intersects(const PixelRect& other) const {
        return x0 < other.x1 && other.x0 < x1 && y0 < other.y1 && other.y0 < y1;
    }
    friend bool operator==(const PixelRect&, const PixelRect&) = default;
};

}  // namespace camrig
