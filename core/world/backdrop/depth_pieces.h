#pragma once

#include <cstdint>
#include <vector>

#include "core/base/image_size.h"
#include "core/base/pixel_rect.h"
#include "core/base/result.h"

namespace camrig::world {

/// How far away each pixel of a picture is, in units; 0: not known, or nothing is there.
struct DepthImage {
    ImageSize size;
    std::vector<std::uint16_t> values;
};

/// Pixels that show one plane, nearly: at (x, y) it is 1 / (inverse + right * (x - x0) + down * (y - y0)) units away.
struct DepthPiece {
    PixelRect rect;
    double inverse = 0.0, right = 0.0, down = 0.0;

    double inverse_at(double x, double y) const { return inverse + right * (x - rect.x0) + down * (y - rect.y0); }
};

/// The pixels that are known, in planes of at most most_px by most_px pixels that do not overlap, and that are off by
/// half a unit or 0.2 % at most; where that takes more than 65536 planes, by twice or four times as much, .. up to
/// 3.2 %. (Depth along the optical axis of a pinhole is exactly so: one over it is linear in pixels for a plane.)
/// Errors: nothing is known, or it is so rough that it takes more planes even then.
Result<std::vector<DepthPiece>> depth_pieces(const DepthImage& image, int most_px);

}  // namespace camrig::world
