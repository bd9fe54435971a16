#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string_view>

#include "core/base/image_size.h"

namespace camrig::frame {

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
    flow32f,  ///< to the right, down
    // Numbers of a sensor, 16 bit each, little-endian.
    gray16,
    bayer_rggb16,  ///< a mosaic, named by its first row and its second
    bayer_grbg16,
    bayer_gbrg16,
    bayer_bggr16,
    rgb16_planes,  ///< all red ones, then green, then blue
};

/// Layouts of colour pictures: what core/frame/convert.h makes of rgba8, and rgba8 itself.
inline constexpr std::array color_formats = {PixelFormat::rgba8,     PixelFormat::bgr24, PixelFormat::rgb24,
                                             PixelFormat::yuyv,      PixelFormat::i420,  PixelFormat::nv12,
                                             PixelFormat::jpeg_i420, PixelFormat::gray8};

/// Layouts of a sensor's numbers.
inline constexpr std::array number_formats = {PixelFormat::gray16,       PixelFormat::bayer_rggb16,
                                              PixelFormat::bayer_grbg16, PixelFormat::bayer_gbrg16,
                                              PixelFormat::bayer_bggr16, PixelFormat::rgb16_planes};

/// Some of both.
class PixelFormats {
public:
    constexpr PixelFormats() = default;
    constexpr PixelFormats(std::initializer_list<PixelFormat> formats) {
        for (const PixelFormat format : formats) add(format);
    }
    constexpr void add(PixelFormat format) { bits_ |= bit(format); }
    constexpr bool contains(PixelFormat format) const { return (bits_ & bit(format)) != 0; }
    constexpr bool contains_numbers() const {
        return std::ranges::any_of(number_formats, [this](PixelFormat format) { return contains(format); });
    }
    constexpr bool empty() const { return bits_ == 0; }
    friend constexpr bool operator==(PixelFormats, PixelFormats) = default;

private:
    static constexpr std::uint32_t bit(PixelFormat format) { return std::uint32_t{1} << static_cast<int>(format); }
    std::uint32_t bits_ = 0;
};

/// Bytes of a picture of this format and size, without padding.
std::size_t bytes_of(PixelFormat format, ImageSize size);
std::string_view to_string(PixelFormat format);

}  // namespace camrig::frame
