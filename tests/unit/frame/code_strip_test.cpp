#include "core/frame/code_strip.h"

#include <gtest/gtest.h>

#include "core/frame/convert.h"
#include "tests/unit/frame/test_pictures.h"

namespace camrig::frame {
namespace {

const CodeStrip examples[] = {{0, 0, 0},
                              {1, 42, 1'680'000'000},
                              {255, 0xffffffffU, max_time_ns},
                              {0xa5, 0xdeadbeefU, -1},
                              {7, 1000000, 123456789012345}};

Frame with_strip(ImageSize size, const CodeStrip& strip, std::uint64_t seed = 1) {
    Frame frame = test::noise(size, PixelFormat::rgba8, seed);
    draw_code_strip(frame.mutable_bytes(), size, strip);
    return frame;
}

TEST(CodeStrip, ReadsWhatWasDrawnAtEverySize) {
    for (const ImageSize size :
         {ImageSize{128, 32}, {129, 35}, {320, 240}, {401, 300}, {640, 480}, {1920, 1080}, {4096, 2160}, {8192, 32}}) {
        for (const CodeStrip& strip : examples) {
            EXPECT_EQ(read_code_strip(with_strip(size, strip).bytes(), size), strip) << size.to_string();
        }
    }
}

TEST(CodeStrip, IsReadableInEveryColourFormat) {
    const ImageSize size{322, 241};
    const Frame frame = with_strip(size, examples[1]);
    for (const PixelFormat format : {PixelFormat::bgr24, PixelFormat::rgb24, PixelFormat::yuyv, PixelFormat::i420,
                                     PixelFormat::nv12, PixelFormat::jpeg_i420, PixelFormat::gray8}) {
        std::vector<std::byte> bytes(bytes_of(format, size));
        ASSERT_TRUE(convert(frame, format, {}, bytes).has_value());
        EXPECT_EQ(read_code_strip(bytes, size, format), examples[1]) << to_string(format);
    }
}

TEST(CodeStrip, SurvivesScaling) {
    const std::pair<ImageSize, ImageSize> cases[] = {
        {{640, 480}, {320, 240}},   {{1270, 720}, {635, 360}}, {{1920, 1080}, {960, 540}}, {{640, 480}, {1280, 960}},
        {{1920, 1080}, {640, 360}}, {{1280, 720}, {848, 477}}, {{128, 96}, {256, 192}},    {{128, 96}, {192, 144}},
        {{256, 192}, {128, 96}},    {{399, 300}, {200, 150}}};
    for (const auto& [from, to] : cases) {
        for (const CodeStrip& strip : examples) {
            std::vector<std::byte> scaled(bytes_of(PixelFormat::rgba8, to));
            ASSERT_TRUE(convert(with_strip(from, strip), PixelFormat::rgba8, to, scaled).has_value());
            EXPECT_EQ(read_code_strip(scaled, to), strip) << from.to_string() << " to " << to.to_string();
        }
    }
}

TEST(CodeStrip, PicturesWithoutOneGiveNothing) {
    for (std::uint64_t seed = 1; seed <= 20; ++seed) {
        EXPECT_FALSE(
            read_code_strip(test::noise({320, 240}, PixelFormat::rgba8, seed).bytes(), {320, 240}).has_value());
    }
    EXPECT_FALSE(read_code_strip(test::smooth({640, 480}).bytes(), {640, 480}).has_value());
    EXPECT_FALSE(read_code_strip({}, {640, 480}).has_value()) << "fewer bytes than the size says";
}

TEST(CodeStrip, OneWrongCellNeverGivesAWrongAnswer) {
    for (int bit = 8; bit < 128; ++bit) {
        Frame frame = with_strip({320, 240}, examples[1]);
        for (int y = 0; y < 4; ++y) {
            for (int x = 0; x < 4; ++x) {
                std::byte* const pixel =
                    frame.mutable_bytes().data() + (((bit / 32 * 4 + y) * 320) + bit % 32 * 4 + x) * 4;
                for (int c = 0; c < 3; ++c) pixel[c] = ~pixel[c];
            }
        }
        // A last cell may heal: a slightly smaller grid reads half of its neighbour.
        const auto read = read_code_strip(frame.bytes(), {320, 240});
        EXPECT_TRUE(!read || (*read == examples[1] && bit % 32 == 31)) << bit;
    }
}

TEST(CodeStrip, TooSmallPicturesStayAsTheyAre) {
    EXPECT_EQ(code_strip_cell({127, 480}), 0);
    EXPECT_EQ(code_strip_cell({640, 31}), 0);
    EXPECT_EQ(code_strip_cell({640, 480}), 8);
    EXPECT_EQ(code_strip_cell({128, 32}), 4);
    const Frame before = test::noise({100, 100});
    Frame after = test::noise({100, 100});
    draw_code_strip(after.mutable_bytes(), {100, 100}, examples[1]);
    EXPECT_TRUE(std::equal(before.bytes().begin(), before.bytes().end(), after.bytes().begin()));
}

// The layout is a contract with readers in other languages (control/python): known cells of a known strip.
TEST(CodeStrip, TheLayoutIsAsDocumented) {
    const Frame frame = with_strip({320, 240}, {1, 2, 3});
    std::string bits;
    for (int bit = 0; bit < 128; ++bit) {
        const auto at = static_cast<std::size_t>(((bit / 32 * 4 + 1) * 320 + bit % 32 * 4 + 1) * 4);
        bits += frame.bytes()[at] == std::byte{255} ? '1' : '0';
    }
    EXPECT_EQ(bits.substr(0, 112),
              std::string("10110010") + "00000001" + std::string(30, '0') + "10" + std::string(62, '0') + "11");
}

}  // namespace
}  // namespace camrig::frame
