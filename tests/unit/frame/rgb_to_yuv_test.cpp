#include "core/frame/rgb_to_yuv.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include <gtest/gtest.h>

#include "tests/unit/frame/test_pictures.h"

// The gates of the accuracy goals: every code within 0.51 of exact arithmetic, bias below 0.02, and the way back to RGB
// within 1 code (full) or 2 codes (limited), over all 2^24 colours in the steps below.
namespace camrig::frame {
namespace {

using test::code;

constexpr double kr = 0.299, kg = 0.587, kb = 0.114;

struct Exact {
    double y, u, v;
};
Exact exact_yuv(YuvRange range, double r, double g, double b) {
    const double luma = kr * r + kg * g + kb * b;
    const double cb = (b - luma) / (2 * (1 - kb)), cr = (r - luma) / (2 * (1 - kr));
    if (range == YuvRange::full) return {luma, 128 + cb, 128 + cr};
    return {16 + luma * 219 / 255, 128 + cb * 224 / 255, 128 + cr * 224 / 255};
}

std::array<double, 3> exact_rgb(YuvRange range, double y, double u, double v) {
    double cb = u - 128, cr = v - 128;
    if (range == YuvRange::limited) {
        y = (y - 16) * 255 / 219;
        cb = cb * 255 / 224;
        cr = cr * 255 / 224;
    }
    const double r = y + 2 * (1 - kr) * cr, b = y + 2 * (1 - kb) * cb;
    return {r, (y - kr * r - kb * b) / kg, b};
}

/// Feeds all colours of a grid, each as a pair of equal pixels, and hands code and colour to `visit`.
template <typename Visit>
void for_each_color(YuvRange range, int step, Visit visit) {
    std::vector<std::byte> row, y, u, v;
    for (int r = 0; r < 256; r += step) {
        for (int g = 0; g < 256; g += step) {
            row.clear();
            for (int b = 0; b < 256; ++b) {
                for (int twice = 0; twice < 2; ++twice) {
                    for (const int c : {r, g, b, 9}) row.push_back(static_cast<std::byte>(c));
                }
            }
            y.resize(512);
            u.resize(256);
            v.resize(256);
            luma_row(range, row.data(), 512, y.data());
            chroma_row(range, row.data(), row.data(), 512, u.data(), v.data());
            for (std::size_t b = 0; b < 256; ++b) {
                ASSERT_EQ(y[2 * b], y[2 * b + 1]);
                visit(r, g, static_cast<int>(b), code(y[2 * b]), code(u[b]), code(v[b]));
            }
        }
    }
}

class YuvConversion : public testing::TestWithParam<YuvRange> {};

TEST_P(YuvConversion, IsTheExactValueRoundedWithoutBias) {
    double worst = 0, sum[3] = {};
    std::int64_t count = 0;
    for_each_color(GetParam(), 3, [&](int r, int g, int b, int y, int u, int v) {
        const Exact exact = exact_yuv(GetParam(), r, g, b);
        const double difference[3] = {y - exact.y, u - exact.u, v - exact.v};
        for (int i = 0; i < 3; ++i) {
            worst = std::max(worst, std::abs(difference[i]));
            sum[i] += difference[i];
        }
        ++count;
    });
    EXPECT_LE(worst, 0.51);
    for (const double s : sum) EXPECT_LT(std::abs(s / static_cast<double>(count)), 0.005);
    RecordProperty("worst", std::to_string(worst));
}

TEST_P(YuvConversion, RoundTripStaysWithinTheStatedCodes) {
    const int allowed = GetParam() == YuvRange::full ? 1 : 2;
    int worst = 0;
    double sum[3] = {};
    std::int64_t count = 0;
    for_each_color(GetParam(), 3, [&](int r, int g, int b, int y, int u, int v) {
        const auto back = exact_rgb(GetParam(), y, u, v);
        const int original[3] = {r, g, b};
        for (std::size_t i = 0; i < 3; ++i) {
            const int rounded = std::clamp(static_cast<int>(std::lround(back[i])), 0, 255);
            worst = std::max(worst, std::abs(rounded - original[i]));
            sum[i] += rounded - original[i];
        }
        ++count;
    });
    EXPECT_LE(worst, allowed);
    for (const double s : sum) EXPECT_LT(std::abs(s / static_cast<double>(count)), 0.02);
}

TEST_P(YuvConversion, GrayHasNoColour) {
    for (int gray = 0; gray < 256; ++gray) {
        const auto g = static_cast<std::byte>(gray);
        const std::byte row[8] = {g, g, g, {}, g, g, g, {}};
        std::byte u, v;
        chroma_row(GetParam(), row, row, 2, &u, &v);
        ASSERT_EQ(code(u), 128);
        ASSERT_EQ(code(v), 128);
    }
}

TEST_P(YuvConversion, ChromaIsTheMeanOfTheBlockAtEveryWidth) {
    for (int width = 1; width <= 67; ++width) {
        const Frame picture = test::noise({width, 2}, PixelFormat::rgba8, static_cast<std::uint64_t>(width));
        const std::byte* const row_0 = picture.bytes().data();
        const std::byte* const row_1 = row_0 + width * 4;
        const int half = (width + 1) / 2;
        // One byte more than needed on each side, to see writes out of bounds.
        std::vector<std::byte> u(static_cast<std::size_t>(half) + 2, std::byte{77}), v = u;
        chroma_row(GetParam(), row_0, row_1, width, u.data() + 1, v.data() + 1);
        for (int x = 0; x < half; ++x) {
            double mean[3] = {};
            for (int i = 0; i < 2; ++i) {
                const int column = std::min(2 * x + i, width - 1);
                for (int c = 0; c < 3; ++c)
                    mean[c] += (code(row_0[column * 4 + c]) + code(row_1[column * 4 + c])) / 4.0;
            }
            const Exact exact = exact_yuv(GetParam(), mean[0], mean[1], mean[2]);
            ASSERT_NEAR(code(u[static_cast<std::size_t>(x) + 1]), exact.u, 0.51) << width << " " << x;
            ASSERT_NEAR(code(v[static_cast<std::size_t>(x) + 1]), exact.v, 0.51) << width << " " << x;
        }
        ASSERT_EQ(u.front(), std::byte{77});
        ASSERT_EQ(u.back(), std::byte{77});
        ASSERT_EQ(v.front(), std::byte{77});
        ASSERT_EQ(v.back(), std::byte{77});
    }
}

INSTANTIATE_TEST_SUITE_P(BothRanges, YuvConversion, testing::Values(YuvRange::full, YuvRange::limited),
                         [](const auto& test) { return test.param == YuvRange::full ? "full" : "limited"; });

}  // namespace
}  // namespace camrig::frame
