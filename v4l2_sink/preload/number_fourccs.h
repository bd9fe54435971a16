#pragma once

// V4L2's pixel formats for raw sensor data (pixfmt-yuv-luma.rst, pixfmt-srggb*.rst of the kernel's documentation): 8
// bits in one byte, more in two, little-endian. Used by the rig and by the preloaded library, which has no C++ runtime.

#include <linux/videodev2.h>
#include <stdint.h>

namespace camrig::device {

/// Bayer pattern: the colours of the first two pixels of the first row, then of the second row.
enum class Mosaic : uint8_t { none, rggb, grbg, gbrg, bggr };

struct NumberFourcc {
    uint32_t fourcc;
    Mosaic mosaic;
    uint8_t bits;
    const char* name;  ///< v4l2_fmtdesc::description, as in the kernel's v4l2-ioctl.c
};

inline constexpr NumberFourcc number_fourccs[] = {
    {V4L2_PIX_FMT_GREY, Mosaic::none, 8, "8-bit Greyscale"},
    {V4L2_PIX_FMT_Y10, Mosaic::none, 10, "10-bit Greyscale"},
    {V4L2_PIX_FMT_Y12, Mosaic::none, 12, "12-bit Greyscale"},
    {V4L2_PIX_FMT_Y14, Mosaic::none, 14, "14-bit Greyscale"},
    {V4L2_PIX_FMT_Y16, Mosaic::none, 16, "16-bit Greyscale"},
    {V4L2_PIX_FMT_SRGGB8, Mosaic::rggb, 8, "8-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB10, Mosaic::rggb, 10, "10-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB12, Mosaic::rggb, 12, "12-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB14, Mosaic::rggb, 14, "14-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SRGGB16, Mosaic::rggb, 16, "16-bit Bayer RGRG/GBGB"},
    {V4L2_PIX_FMT_SGRBG8, Mosaic::grbg, 8, "8-bit Bayer GRGR/BGBG"},
    {V4L2_PIX_FMT_SGRBG10, Mosaic::grbg, 10, "10-bit Bayer GRGR/BGBG"},
    {V4L2_PIX_FMT_SGRBG12, Mosaic::grbg, 12, "12-bit Bayer GRGR/BGBG"},
    {V4L2_PIX_FMT_SGRBG14, Mosaic::grbg, 14, "14-bit Bayer GRGR/BGBG"},
    {V4L2_PIX_FMT_SGRBG16, Mosaic::grbg, 16, "16-bit Bayer GRGR/BGBG"},
    {V4L2_PIX_FMT_SGBRG8, Mosaic::gbrg, 8, "8-bit Bayer GBGB/RGRG"},
    {V4L2_PIX_FMT_SGBRG10, Mosaic::gbrg, 10, "10-bit Bayer GBGB/RGRG"},
    {V4L2_PIX_FMT_SGBRG12, Mosaic::gbrg, 12, "12-bit Bayer GBGB/RGRG"},
    {V4L2_PIX_FMT_SGBRG14, Mosaic::gbrg, 14, "14-bit Bayer GBGB/RGRG"},
    {V4L2_PIX_FMT_SGBRG16, Mosaic::gbrg, 16, "16-bit Bayer GBGB/RGRG"},
    {V4L2_PIX_FMT_SBGGR8, Mosaic::bggr, 8, "8-bit Bayer BGBG/GRGR"},
    {V4L2_PIX_FMT_SBGGR10, Mosaic::bggr, 10, "10-bit Bayer BGBG/GRGR"},
    {V4L2_PIX_FMT_SBGGR12, Mosaic::bggr, 12, "12-bit Bayer BGBG/GRGR"},
    {V4L2_PIX_FMT_SBGGR14, Mosaic::bggr, 14, "14-bit Bayer BGBG/GRGR"},
    {V4L2_PIX_FMT_SBGGR16, Mosaic::bggr, 16, "16-bit Bayer BGBG/GRGR"},
};

/// Null if the pixel format is not one of raw sensor data.
constexpr const NumberFourcc* number_fourcc(uint32_t fourcc) {
    for (const NumberFourcc& one : number_fourccs)
        if (one.fourcc == fourcc) return &one;
    return nullptr;
}
constexpr uint32_t bytes_a_number(const NumberFourcc& format) {
    return format.bits == 8 ? 1 : 2;
}

}  // namespace camrig::device
