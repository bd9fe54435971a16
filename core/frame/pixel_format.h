#pragma once

#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/base/image_size.h"

namespace camrig {

/// YUV formats are BT.601 limited range unless a name says otherwise; chroma planes are rounded up for odd sizes.
enum class PixelFormat : std::uint8_t {
    rgba8,      ///< R G B A bytes
    bgr24,      ///< B G R bytes (V4L2 BGR3, OpenCV)
    rgb24,      ///< R G B bytes
    yuyv,       ///< 4:2:2 packed (V4L2 YUYV); even width
    i420,       ///< 4:2:0 planar Y U V (V4L2 YU12)
    nv12,       ///< 4:2:0 Y, then UV interleaved
    jpeg_i420,  ///< 4:2:0 planar, BT.601 full range (JFIF): what a JPEG encoder takes
    gray8,
    depth32f,
    id32,
    normal32f,
};

/// Bytes of a picture of this format and size, without padding.
std::size_t bytes_of(PixelFormat format, ImageSize size);
std::string_view to_string(PixelFormat format);

}  // namespace camrig
