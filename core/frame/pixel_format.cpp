#include "core/frame/pixel_format.h"

#include "core/base/result.h"

namespace camrig::frame {

std::size_t bytes_of(PixelFormat format, ImageSize size) {
    CHECK(size.width >= 0 && size.height >= 0);
    const auto pixels = static_cast<std::size_t>(size.pixels());
    const auto half_width = static_cast<std::size_t>((size.width + 1) / 2);
    const auto half_height = static_cast<std::size_t>((size.height + 1) / 2);
    switch (format) {
        case PixelFormat::rgba8:
        case PixelFormat::depth32f:
        case PixelFormat::id32:
            return pixels * 4;
        case PixelFormat::bgr24:
        case PixelFormat::rgb24:
            return pixels * 3;
        case PixelFormat::yuyv:
            return half_width * 4 * static_cast<std::size_t>(size.height);
        case PixelFormat::i420:
        case PixelFormat::nv12:
        case PixelFormat::jpeg_i420:
            return pixels + half_width * half_height * 2;
        case PixelFormat::gray8:
            return pixels;
        case PixelFormat::normal32f:
            return pixels * 12;
        case PixelFormat::flow32f:
            return pixels * 8;
        case PixelFormat::gray16:
        case PixelFormat::bayer_rggb16:
        case PixelFormat::bayer_grbg16:
        case PixelFormat::bayer_gbrg16:
        case PixelFormat::bayer_bggr16:
            return pixels * 2;
        case PixelFormat::rgb16_planes:
            return pixels * 6;
    }
    CHECK(!"known pixel format");
    return 0;
}

std::string_view to_string(PixelFormat format) {
    switch (format) {
        case PixelFormat::rgba8:
            return "rgba8";
        case PixelFormat::bgr24:
            return "bgr24";
        case PixelFormat::rgb24:
            return "rgb24";
        case PixelFormat::yuyv:
            return "yuyv";
        case PixelFormat::i420:
            return "i420";
        case PixelFormat::nv12:
            return "nv12";
        case PixelFormat::jpeg_i420:
            return "jpeg_i420";
        case PixelFormat::gray8:
            return "gray8";
        case PixelFormat::depth32f:
            return "depth32f";
        case PixelFormat::id32:
            return "id32";
        case PixelFormat::normal32f:
            return "normal32f";
        case PixelFormat::flow32f:
            return "flow32f";
        case PixelFormat::gray16:
            return "gray16";
        case PixelFormat::bayer_rggb16:
            return "bayer_rggb16";
        case PixelFormat::bayer_grbg16:
            return "bayer_grbg16";
        case PixelFormat::bayer_gbrg16:
            return "bayer_gbrg16";
        case PixelFormat::bayer_bggr16:
            return "bayer_bggr16";
        case PixelFormat::rgb16_planes:
            return "rgb16_planes";
    }
    return "unknown";
}

}  // namespace camrig::frame
