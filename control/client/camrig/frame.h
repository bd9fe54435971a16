#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <camrig/parameters.h>

namespace camrig::client {

/// Which frame, and how it travels.
struct FrameRequest {
    std::string kind = "color";  ///< color, depth, instance, semantic, normal, sensor, flow or soiling
    std::int64_t min_ns = 0;  ///< the first frame that shows this world time or a later one; waits up to 10 s for it,
                              ///< or two frames of a slower camera
    std::string format = "raw";  ///< raw is exact, png too but for depth (whole mm, to 65.535 m); jpeg is color only
    int quality = 90;            ///< of jpeg, 1 to 100
};

/// One picture and the instant it shows. Cameras that are due at one instant have the same time_ns.
///
/// Raw pictures are rows from the top without padding: rgba8 (color), depth32f (metres along the optical axis, infinite
/// where nothing is), id32 (instance, semantic; 0 where nothing is), normal32f (x, y, z), flow32f (pixels to
/// the right and down until the next frame, NaN where nothing is), gray8 (soiling; 255: all light is taken), or 16-bit
/// numbers of a sensor: gray16, bayer_rggb16, bayer_grbg16, bayer_gbrg16, bayer_bggr16, rgb16_planes. For cv::Mat see
/// <camrig/opencv.h>.
struct Frame {
    std::string camera = {};
    std::string kind = {};
    std::string format = {};  ///< as asked
    std::string pixels = {};  ///< of raw pictures: their layout
    Size size = {};
    std::int64_t sequence = 0;      ///< a gap is a dropped frame
    std::int64_t time_ns = 0;       ///< world time that it shows
    std::int64_t monotonic_ns = 0;  ///< CLOCK_MONOTONIC time of that instant, on the rig's machine
    std::int64_t stamp_ns = 0;      ///< time_ns as the camera's clock says it; the same unless it has one
    std::int64_t steady_ns = 0;     ///< monotonic_ns as its monotonic clock says it
    std::vector<std::byte> data = {};
};

}  // namespace camrig::client
