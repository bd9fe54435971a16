#include "tools/probe/gray.h"

#include <array>

#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include "core/codec/encoder.h"

namespace camrig::probe {
namespace {

std::vector<int> codes(const std::vector<std::byte>& gray) {
    std::vector<int> all;
    for (const std::byte code : gray) all.push_back(std::to_integer<int>(code));
    return all;
}

TEST(Gray, EachFormatGivesItsBrightness) {
    // Two pixels wide, two rows with one byte (or pixel) of padding.
    constexpr std::array<unsigned char, 32> bytes{10, 11, 12, 13, 14, 15, 16, 17, 18, 19, 20, 21, 22, 23, 24, 25,
                                                  26, 27, 28, 29, 30, 31, 32, 33, 34, 35, 36, 37, 38, 39, 40, 41};
    std::vector<std::byte> gray;
    const auto read = [&](std::uint32_t fourcc, std::size_t row) {
        EXPECT_TRUE(gray_from_raw(fourcc, std::as_bytes(std::span(bytes)), {2, 2}, row, gray));
        return codes(gray);
    };
    EXPECT_EQ(read(V4L2_PIX_FMT_YUYV, 0), (std::vector{10, 12, 14, 16}));
    EXPECT_EQ(read(V4L2_PIX_FMT_UYVY, 6), (std::vector{11, 13, 17, 19}));
    EXPECT_EQ(read(V4L2_PIX_FMT_YUV420, 3), (std::vector{10, 11, 13, 14}));
    EXPECT_EQ(read(V4L2_PIX_FMT_BGR24, 0), (std::vector{11, 14, 17, 20}));
    EXPECT_EQ(read(V4L2_PIX_FMT_GREY, 0), (std::vector{10, 11, 12, 13}));
}

TEST(Gray, ShortPicturesAndUnknownFormatsAreRefused) {
    std::array<std::byte, 15> bytes{};
    std::vector<std::byte> gray;
    EXPECT_FALSE(gray_from_raw(V4L2_PIX_FMT_YUYV, bytes, {4, 2}, 0, gray));
    EXPECT_FALSE(gray_from_raw(V4L2_PIX_FMT_YUYV, bytes, {4, 1}, 4, gray));
    EXPECT_FALSE(gray_from_raw(V4L2_PIX_FMT_GREY, bytes, {0, 1}, 0, gray));
    EXPECT_FALSE(gray_from_raw(v4l2_fourcc('n', 'o', 'n', 'e'), bytes, {2, 2}, 0, gray));
}

TEST(Gray, AJpegThatEndsEarlyIsBroken) {
    frame::FrameInfo info;
    info.size = {64, 48};
    std::vector<std::byte> noise(bytes_of(frame::PixelFormat::rgba8, info.size));
    for (std::size_t i = 0; i < noise.size(); ++i) noise[i] = static_cast<std::byte>(i * i % 251);
    const frame::Frame frame(info, std::move(noise));
    auto encoder = codec::create_jpeg_encoder(90);
    const auto jpeg = encoder.value()->encode(frame);
    ASSERT_TRUE(jpeg) << jpeg.error().message;
    ImageSize size;
    std::vector<std::byte> gray;
    const std::span<const std::byte> whole((*jpeg)->data(), (*jpeg)->size());
    EXPECT_TRUE(gray_from_jpeg(whole, size, gray));
    EXPECT_EQ(size, (ImageSize{64, 48}));
    EXPECT_FALSE(gray_from_jpeg(whole.first(whole.size() / 2), size, gray));
    EXPECT_FALSE(gray_from_jpeg({}, size, gray));
}

}  // namespace
}  // namespace camrig::probe
