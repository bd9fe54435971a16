#include "core/frame/convert.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/frame/rgb_to_yuv.h"
#include "tests/unit/frame/test_pictures.h"

namespace camrig::frame {
namespace {

using test::code;

std::vector<std::byte> converted_bytes(const Frame& frame, PixelFormat format, ImageSize size = {}) {
    std::vector<std::byte> out(bytes_of(format, size == ImageSize{} ? frame.info().size : size));
    EXPECT_TRUE(convert(frame, format, size, out).has_value());
    return out;
}

constexpr ImageSize sizes[] = {{16, 16}, {17, 33}, {1, 1}, {3, 2}, {2, 3}, {100, 75}, {641, 359}};

TEST(Convert, PackedRgbKeepsEveryPixel) {
    for (const ImageSize size : sizes) {
        const Frame frame = test::noise(size);
        const auto rgb = converted_bytes(frame, PixelFormat::rgb24);
        const auto bgr = converted_bytes(frame, PixelFormat::bgr24);
        for (std::size_t i = 0; i < static_cast<std::size_t>(size.pixels()); ++i) {
            for (std::size_t c = 0; c < 3; ++c) {
                ASSERT_EQ(rgb[3 * i + c], frame.bytes()[4 * i + c]) << size.to_string();
                ASSERT_EQ(bgr[3 * i + c], frame.bytes()[4 * i + 2 - c]) << size.to_string();
            }
        }
    }
}

TEST(Convert, PlanesAreWhereTheFormatSaysAtOddSizesToo) {
    for (const ImageSize size : sizes) {
        const Frame frame = test::noise(size);
        const auto [width, height] = size;
        const int half_width = (width + 1) / 2, half_height = (height + 1) / 2;
        const auto i420 = converted_bytes(frame, PixelFormat::i420);
        const auto nv12 = converted_bytes(frame, PixelFormat::nv12);
        const auto yuyv = converted_bytes(frame, PixelFormat::yuyv);
        const auto at = [](const auto& bytes, std::int64_t i) {
            return test::code(bytes[static_cast<std::size_t>(i)]);
        };

        std::vector<std::byte> u(static_cast<std::size_t>(half_width)), v = u, luma(static_cast<std::size_t>(width));
        for (int y = 0; y < height; ++y) {
            const std::byte* const row = frame.bytes().data() + y * width * 4;
            luma_row(YuvRange::limited, row, width, luma.data());
            chroma_row(YuvRange::limited, row, row, width, u.data(), v.data());
            for (int x = 0; x < width; ++x) {
                ASSERT_EQ(at(i420, y * width + x), at(luma, x));
                ASSERT_EQ(at(nv12, y * width + x), at(luma, x));
                ASSERT_EQ(at(yuyv, y * half_width * 4 + 2 * x), at(luma, x));
            }
            for (int x = 0; x < half_width; ++x) {
                ASSERT_EQ(at(yuyv, y * half_width * 4 + 4 * x + 1), at(u, x));
                ASSERT_EQ(at(yuyv, y * half_width * 4 + 4 * x + 3), at(v, x));
            }
            if (width % 2) {
                ASSERT_EQ(at(yuyv, (y + 1) * half_width * 4 - 2), at(luma, width - 1));
            }
        }
        for (int y = 0; y < half_height; ++y) {
            const std::byte* const row_0 = frame.bytes().data() + 2 * y * width * 4;
            const std::byte* const row_1 = 2 * y + 1 < height ? row_0 + width * 4 : row_0;
            chroma_row(YuvRange::limited, row_0, row_1, width, u.data(), v.data());
            for (int x = 0; x < half_width; ++x) {
                const std::int64_t i = y * half_width + x;
                ASSERT_EQ(at(i420, size.pixels() + i), at(u, x));
                ASSERT_EQ(at(i420, size.pixels() + half_width * half_height + i), at(v, x));
                ASSERT_EQ(at(nv12, size.pixels() + 2 * i), at(u, x));
                ASSERT_EQ(at(nv12, size.pixels() + 2 * i + 1), at(v, x));
            }
        }
    }
}

TEST(Convert, RangesAreAsNamed) {
    Frame white = test::smooth({16, 16});
    for (std::byte& b : white.mutable_bytes()) b = std::byte{255};
    EXPECT_EQ(code(converted_bytes(white, PixelFormat::i420)[0]), 235);
    EXPECT_EQ(code(converted_bytes(white, PixelFormat::jpeg_i420)[0]), 255);
    EXPECT_EQ(code(converted_bytes(white, PixelFormat::gray8)[0]), 255);
    for (std::byte& b : white.mutable_bytes()) b = std::byte{0};
    EXPECT_EQ(code(converted_bytes(white, PixelFormat::i420)[0]), 16);
    EXPECT_EQ(code(converted_bytes(white, PixelFormat::jpeg_i420)[0]), 0);
}

TEST(Convert, HalvingIsTheMeanOfFourPixels) {
    const Frame frame = test::noise({64, 48});
    const auto half = converted_bytes(frame, PixelFormat::rgba8, {32, 24});
    for (int y = 0; y < 24; ++y) {
        for (int x = 0; x < 32; ++x) {
            for (int c = 0; c < 3; ++c) {
                double mean = 0;
                for (int j = 0; j < 2; ++j) {
                    for (int i = 0; i < 2; ++i) {
                        mean += code(frame.bytes()[static_cast<std::size_t>(((2 * y + j) * 64 + 2 * x + i) * 4 + c)]);
                    }
                }
                ASSERT_NEAR(code(half[static_cast<std::size_t>((y * 32 + x) * 4 + c)]), mean / 4, 1.0);
            }
        }
    }
}

TEST(Convert, ScalingKeepsASmoothPictureInPlace) {
    const Frame frame = test::smooth({640, 480});
    for (const ImageSize size : {ImageSize{320, 240}, {500, 375}, {1000, 750}, {161, 121}, {100, 75}}) {
        const auto scaled = converted_bytes(frame, PixelFormat::rgba8, size);
        const Frame wanted = test::smooth(size);
        for (std::size_t i = 0; i < scaled.size(); ++i) {
            ASSERT_NEAR(code(scaled[i]), code(wanted.bytes()[i]), 3) << size.to_string() << " " << i;
        }
    }
}

TEST(Converted, AFrameThatIsAsWantedComesBackItself) {
    FramePool pool;
    const auto frame = std::make_shared<const Frame>(test::noise({16, 16}));
    EXPECT_EQ(converted(pool, frame, PixelFormat::rgba8, {}).value(), frame);
    EXPECT_EQ(converted(pool, frame, PixelFormat::rgba8, {16, 16}).value(), frame);
    const auto depth = std::make_shared<const Frame>(test::noise({16, 16}, PixelFormat::depth32f));
    EXPECT_EQ(converted(pool, depth, PixelFormat::depth32f, {}).value(), depth);
}

TEST(Converted, CarriesTheInstantAndGivesItsMemoryBack) {
    FramePool pool;
    const auto frame = std::make_shared<const Frame>(test::smooth({64, 48}));
    auto small = converted(pool, frame, PixelFormat::yuyv, {32, 24}).value();
    EXPECT_EQ(small->info().size, (ImageSize{32, 24}));
    EXPECT_EQ(small->info().format, PixelFormat::yuyv);
    EXPECT_EQ(small->info().sequence, frame->info().sequence);
    EXPECT_EQ(small->info().world_ns, frame->info().world_ns);
    EXPECT_EQ(*small->info().camera, "lobby");

    std::vector<std::byte> direct(bytes_of(PixelFormat::yuyv, {32, 24}));
    ASSERT_TRUE(convert(*frame, PixelFormat::yuyv, {32, 24}, direct).has_value());
    EXPECT_TRUE(std::equal(direct.begin(), direct.end(), small->bytes().begin(), small->bytes().end()));
    small.reset();
    EXPECT_EQ(pool.idle_bytes(), 32U * 24 * 4 + 32 * 24 * 2);
}

TEST(Converted, KeepsTheDamageUnlessItIsScaled) {
    FramePool pool;
    const Frame first = test::noise({33, 47});
    FrameInfo info = first.info();
    info.sequence += 1;
    info.damage = Damage::since(first.info().sequence);
    info.damage.add(16, 32);
    std::vector<std::byte> bytes(first.bytes().begin(), first.bytes().end());
    std::fill(bytes.begin() + 16 * 33 * 4, bytes.begin() + 32 * 33 * 4, std::byte{77});
    const auto second = std::make_shared<const Frame>(info, std::move(bytes));

    const auto planes = converted(pool, second, PixelFormat::jpeg_i420, {}).value();
    EXPECT_EQ(planes->info().damage, info.damage);
    const auto before = converted_bytes(first, PixelFormat::jpeg_i420);
    const auto differs = [&](int from, int to) {
        return !std::equal(before.begin() + from, before.begin() + to, planes->bytes().begin() + from);
    };
    const int u = 33 * 47, v = u + 17 * 24, end = v + 17 * 24;
    EXPECT_FALSE(differs(0, 16 * 33) || differs(32 * 33, u)) << "Y";
    EXPECT_FALSE(differs(u, u + 8 * 17) || differs(u + 16 * 17, v)) << "U";
    EXPECT_FALSE(differs(v, v + 8 * 17) || differs(v + 16 * 17, end)) << "V";
    EXPECT_TRUE(differs(16 * 33, 32 * 33));

    const auto small = converted(pool, second, PixelFormat::rgba8, {16, 24}).value();
    EXPECT_EQ(small->info().damage, Damage{});
    EXPECT_EQ(converted(pool, second, PixelFormat::gray8, {16, 24}).value()->info().damage, Damage{});
}

/// The frame that follows, with new pixels in some rows.
FrameRef changed(const FrameRef& frame, int first_row, int end_row) {
    FrameInfo info = frame->info();
    info.damage = Damage::since(info.sequence++);
    info.damage.add(first_row, end_row);
    std::vector<std::byte> bytes(frame->bytes().begin(), frame->bytes().end());
    const std::ptrdiff_t row_bytes = 4 * std::ptrdiff_t{info.size.width};
    for (auto i = bytes.begin() + first_row * row_bytes; i != bytes.begin() + end_row * row_bytes; ++i)
        *i ^= std::byte{0x5a};
    return std::make_shared<const Frame>(std::move(info), std::move(bytes));
}

constexpr PixelFormat written_formats[] = {PixelFormat::bgr24, PixelFormat::rgb24, PixelFormat::yuyv,
                                           PixelFormat::i420,  PixelFormat::nv12,  PixelFormat::jpeg_i420,
                                           PixelFormat::gray8};

TEST(Converted, WhatDidNotChangeIsCopiedAndNobodyCanTell) {
    for (const ImageSize size : {ImageSize{64, 64}, {33, 47}, {17, 16}, {50, 81}}) {
        for (const PixelFormat format : written_formats) {
            FramePool pool;
            FrameRef frame = std::make_shared<const Frame>(test::noise(size));
            FrameRef last = converted(pool, frame, format, {}).value();
            const int h = size.height;
            for (const auto& [first, end] : {std::pair{0, 0}, {0, 1}, {h - 1, h}, {3, h / 2}, {h / 2, h}, {0, h}}) {
                frame = changed(frame, first, end);
                const FrameRef quick = converted(pool, frame, format, {}, last).value();
                const FrameRef full = converted(pool, frame, format, {}).value();
                ASSERT_TRUE(std::ranges::equal(quick->bytes(), full->bytes()))
                    << size.to_string() << " " << to_string(format) << ", rows from " << first << " to " << end;
                last = quick;
            }
        }
    }
}

TEST(Converted, OnlyWhatChangedIsConvertedWhereTheLastOneIsKnown) {
    FramePool pool;
    const auto first = std::make_shared<const Frame>(test::noise({64, 64}));
    const FrameRef second = changed(first, 20, 30);
    for (const PixelFormat format : written_formats) {
        FrameInfo info = first->info();
        info.format = format;
        // A last picture of nothing but 7s shows how much was taken from it.
        const auto sevens = [&](const FrameInfo& last_info, const FrameRef& frame) {
            const auto last = std::make_shared<const Frame>(
                last_info, std::vector<std::byte>(bytes_of(last_info.format, last_info.size), std::byte{7}));
            const FrameRef out = converted(pool, frame, format, {}, last).value();
            const auto count = std::ranges::count(out->bytes(), std::byte{7});
            return static_cast<double>(count) / static_cast<double>(out->bytes().size());
        };
        EXPECT_NEAR(sevens(info, second), 0.75, 0.02) << to_string(format) << ": 48 of 64 rows";
        FrameInfo other = info;
        other.sequence -= 1;
        EXPECT_LT(sevens(other, second), 0.1) << "a frame was left out";
        other = info;
        other.camera_id = CameraId{8};
        EXPECT_LT(sevens(other, second), 0.1) << "another camera";
        other = info;
        other.size = {64, 80};
        EXPECT_LT(sevens(other, second), 0.1) << "another size";
        other = info;
        other.format = PixelFormat::rgba8;
        EXPECT_LT(sevens(other, second), 0.1) << "another layout";
        EXPECT_LT(sevens(info, first), 0.1) << "not known";
    }
}

TEST(Converted, WhatIsNoColourIsRefused) {
    FramePool pool;
    const auto depth = std::make_shared<const Frame>(test::noise({16, 16}, PixelFormat::depth32f));
    EXPECT_EQ(converted(pool, depth, PixelFormat::i420, {}).error().kind, ErrorKind::unsupported);
    const auto color = std::make_shared<const Frame>(test::noise({16, 16}));
    EXPECT_EQ(converted(pool, color, PixelFormat::depth32f, {}).error().kind, ErrorKind::unsupported);
    EXPECT_EQ(converted(pool, color, PixelFormat::i420, {-1, 5}).error().kind, ErrorKind::invalid_argument);
    EXPECT_EQ(converted(pool, color, PixelFormat::i420, {16, 9000}).error().kind, ErrorKind::invalid_argument);
}

}  // namespace
}  // namespace camrig::frame
