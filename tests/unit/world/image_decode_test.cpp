#include "core/world/gltf/image_decode.h"

#include <algorithm>
#include <array>
#include <memory>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <png.h>
#include <turbojpeg.h>

namespace camrig::world::gltf {
namespace {

using Rgba = std::array<int, 4>;

/// A picture of 32 x 16: the upper half orange, the lower blue.
constexpr int width = 32, height = 16;
constexpr std::array<std::uint8_t, 3> orange = {200, 100, 50}, blue = {10, 60, 220};
std::vector<std::uint8_t> two_halves() {
    std::vector<std::uint8_t> rgb;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            rgb.insert(rgb.end(), y < height / 2 ? orange.begin() : blue.begin(),
                       y < height / 2 ? orange.end() : blue.end());
    return rgb;
}

std::vector<std::byte> jpeg_of(const std::vector<std::uint8_t>& rgb, int subsampling, int flags = 0) {
    const std::unique_ptr<void, int (*)(tjhandle)> jpeg(tjInitCompress(), tjDestroy);
    unsigned char* out = nullptr;
    unsigned long size = 0;
    EXPECT_EQ(tjCompress2(jpeg.get(), rgb.data(), width, 0, height, TJPF_RGB, &out, &size, subsampling, 100,
                          flags | TJFLAG_ACCURATEDCT),
              0);
    const auto* begin = reinterpret_cast<const std::byte*>(out);
    std::vector<std::byte> bytes(begin, begin + size);
    tjFree(out);
    return bytes;
}

/// Rows as PNG keeps them (16-bit values high byte first).
std::vector<std::byte> png_of(const std::vector<std::uint8_t>& rows, int w, int h, int depth, int color_type,
                              int interlace = PNG_INTERLACE_NONE) {
    std::vector<std::byte> bytes;
    png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(png);
    png_set_write_fn(
        png, &bytes,
        [](png_structp p, png_bytep data, std::size_t size) {
            auto& out = *static_cast<std::vector<std::byte>*>(png_get_io_ptr(p));
            const auto* from = reinterpret_cast<const std::byte*>(data);
            out.insert(out.end(), from, from + size);
        },
        nullptr);
    png_set_IHDR(png, info, static_cast<png_uint_32>(w), static_cast<png_uint_32>(h), depth, color_type, interlace,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    png_set_gAMA(png, info, 1.0);  // glTF 2.0, 3.8.1: colour space information in a picture is ignored
    png_write_info(png, info);
    const int passes = png_set_interlace_handling(png);
    const std::size_t stride = rows.size() / static_cast<std::size_t>(h);
    for (int pass = 0; pass < passes; ++pass)
        for (std::size_t y = 0; y < static_cast<std::size_t>(h); ++y) png_write_row(png, rows.data() + y * stride);
    png_write_end(png, nullptr);
    png_destroy_write_struct(&png, &info);
    return bytes;
}

Image decode(const std::vector<std::byte>& bytes) {
    Budget budget;
    return decode_image(bytes, "picture", budget);
}

std::string error_of(const std::vector<std::byte>& bytes) {
    try {
        decode(bytes);
        return "decoded";
    } catch (const Failure& failure) {
        return failure.error.message;
    }
}

Rgba pixel(const Image& image, int x, int y) {
    const auto* p = image.rgba.data() + 4 * (y * image.size.width + x);
    return {p[0], p[1], p[2], p[3]};
}

void expect_near(const Rgba& got, const std::array<std::uint8_t, 3>& rgb, int tolerance) {
    for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(got[c], rgb[c], tolerance) << "channel " << c;
    EXPECT_EQ(got[3], 255);
}

TEST(DecodeImage, JpegColoursComeBackInOrderAndTopRowFirst) {
    for (const int subsampling : {TJSAMP_444, TJSAMP_422, TJSAMP_420}) {
        for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
            const Image image = decode(jpeg_of(two_halves(), subsampling, flags));
            ASSERT_EQ(image.size, (ImageSize{width, height}));
            // The colours end at a block border, so only rounding and the standard's YCbCr are between.
            expect_near(pixel(image, 5, 2), orange, 2);
            expect_near(pixel(image, width - 1, height - 1), blue, 2);
        }
    }
}

TEST(DecodeImage, GrayJpegsBecomeGrayRgb) {
    const Image image = decode(jpeg_of(two_halves(), TJSAMP_GRAY));
    const Rgba p = pixel(image, 3, 3);
    EXPECT_NEAR(p[0], 0.299 * 200 + 0.587 * 100 + 0.114 * 50, 1.5);
    EXPECT_EQ(p[0], p[1]);
    EXPECT_EQ(p[1], p[2]);
}

TEST(DecodeImage, PngColoursAreExact) {
    for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
        const Image image = decode(png_of(two_halves(), width, height, 8, PNG_COLOR_TYPE_RGB, interlace));
        expect_near(pixel(image, 5, 2), orange, 0);
        expect_near(pixel(image, width - 1, height - 1), blue, 0);
    }
}

TEST(DecodeImage, PngsOfAllDepthsBecomeEightBitRgba) {
    // Two gray pixels of one bit; two of gray and alpha; one of 16-bit RGBA, rounded to the nearest of eight bits.
    const Image bits = decode(png_of({0b01000000}, 2, 1, 1, PNG_COLOR_TYPE_GRAY));
    EXPECT_EQ(pixel(bits, 0, 0), (Rgba{0, 0, 0, 255}));
    EXPECT_EQ(pixel(bits, 1, 0), (Rgba{255, 255, 255, 255}));
    const Image alpha = decode(png_of({10, 20, 30, 40}, 2, 1, 8, PNG_COLOR_TYPE_GRAY_ALPHA));
    EXPECT_EQ(pixel(alpha, 1, 0), (Rgba{30, 30, 30, 40}));
    const Image deep =
        decode(png_of({0x00, 0xFF, 0xFE, 0xFF, 0x12, 0x12, 0x80, 0x00}, 1, 1, 16, PNG_COLOR_TYPE_RGB_ALPHA));
    EXPECT_EQ(pixel(deep, 0, 0), (Rgba{1, 254, 0x12, 128}));
}

TEST(DecodeImage, SixteenBitGrayKeepsItsNumbersAndOthersAreRefused) {
    const auto gray = [](std::span<const std::byte> bytes) {
        Budget budget;
        return decode_gray16(bytes, "depth", budget);
    };
    for (const int interlace : {PNG_INTERLACE_NONE, PNG_INTERLACE_ADAM7}) {
        const Gray16 image =
            gray(png_of({0x12, 0x34, 0x00, 0xFF, 0xFF, 0x00}, 3, 1, 16, PNG_COLOR_TYPE_GRAY, interlace));
        EXPECT_EQ(image.size, (ImageSize{3, 1}));
        EXPECT_EQ(image.values, (std::vector<std::uint16_t>{0x1234, 0x00FF, 0xFF00}));
    }
    const auto refused = [&](std::span<const std::byte> bytes) {
        try {
            gray(bytes);
        } catch (const Failure& failure) {
            return failure.error.message;
        }
        return std::string("read");
    };
    EXPECT_EQ(refused(png_of({1, 2, 3}, 3, 1, 8, PNG_COLOR_TYPE_GRAY)), "depth: has to be gray, of 16 bits");
    EXPECT_EQ(refused(png_of({1, 2, 3, 4, 5, 6}, 1, 1, 16, PNG_COLOR_TYPE_RGB)), "depth: has to be gray, of 16 bits");
    auto cut = png_of(std::vector<std::uint8_t>(2 * 64 * 64, 9), 64, 64, 16, PNG_COLOR_TYPE_GRAY);
    cut.resize(cut.size() / 2);
    EXPECT_THAT(refused(cut), testing::StartsWith("depth: PNG: "));
    EXPECT_EQ(refused(jpeg_of(two_halves(), TJSAMP_444)), "depth: is no PNG");
}

TEST(DecodeImage, DamagedPicturesAreErrorsWithTheirPlace) {
    const auto jpeg = jpeg_of(two_halves(), TJSAMP_420);
    const auto png = png_of(two_halves(), width, height, 8, PNG_COLOR_TYPE_RGB);
    for (const auto& whole : {jpeg, png}) {
        for (const std::size_t size : {std::size_t{4}, whole.size() / 4, whole.size() / 2}) {
            const std::vector<std::byte> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
            EXPECT_THAT(error_of(cut), testing::StartsWith("picture: ")) << size;
        }
    }
    EXPECT_THAT(error_of(std::vector<std::byte>(20)), testing::HasSubstr("neither a PNG nor a JPEG"));
}

TEST(DecodeImage, APictureThatClaimsMoreThanItsBytesCanHoldGetsNoMemory) {
    auto png = png_of(two_halves(), width, height, 8, PNG_COLOR_TYPE_RGB);
    for (const std::size_t at : {std::size_t{18}, std::size_t{22}}) png[at] = std::byte{0x30};  // 12320 x 12304
    EXPECT_THAT(error_of(png), testing::HasSubstr("picture: PNG"));
    auto jpeg = jpeg_of(two_halves(), TJSAMP_444);
    const std::byte frame[] = {std::byte{0xFF}, std::byte{0xC0}};
    const auto found = std::ranges::search(jpeg, frame).begin();
    ASSERT_NE(found, jpeg.end());
    found[5] = found[7] = std::byte{0x3F};
    EXPECT_THAT(error_of(jpeg), testing::HasSubstr("JPEG: the data ends too early"));
}

}  // namespace
}  // namespace camrig::world::gltf
