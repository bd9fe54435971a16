#include "core/frame/pixel_format.h"

#include <gtest/gtest.h>

namespace camrig::frame {
namespace {

TEST(PixelFormat, OddSizesRoundChromaUp) {
    EXPECT_EQ(bytes_of(PixelFormat::i420, {17, 17}), 17U * 17 + 2 * 9 * 9);
    EXPECT_EQ(bytes_of(PixelFormat::jpeg_i420, {1, 1}), 3U);
    EXPECT_EQ(bytes_of(PixelFormat::nv12, {16, 3}), 48U + 2 * 8 * 2);
    EXPECT_EQ(bytes_of(PixelFormat::yuyv, {17, 2}), 36U * 2);
}

TEST(PixelFormat, TheLargestPictureDoesNotOverflow) {
    EXPECT_EQ(bytes_of(PixelFormat::rgba8, max_image_size), std::size_t{8192} * 8192 * 4);
    EXPECT_EQ(bytes_of(PixelFormat::normal32f, max_image_size), std::size_t{8192} * 8192 * 12);
}

TEST(PixelFormat, NamesAreTheProtocols) {
    EXPECT_EQ(to_string(PixelFormat::rgba8), "rgba8");
    EXPECT_EQ(to_string(PixelFormat::jpeg_i420), "jpeg_i420");
}

}  // namespace
}  // namespace camrig::frame
