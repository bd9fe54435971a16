#pragma once

#include <cstdint>
#include <vector>

namespace camrig::frame {

/// Pixels x0 <= x < x1 of row y.
struct PixelRun {
    int y = 0, x0 = 0, x1 = 0;
    friend bool operator==(const PixelRun&, const PixelRun&) = default;
};

/// The pixels that an object would show if nothing else were there: row by row, from left to right.
using Silhouette = std::vector<PixelRun>;

}  // namespace camrig::frame
