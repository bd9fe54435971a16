#include <algorithm>
#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "core/sensor/normal_tables.h"
#include "tests/unit/sensor/flat_light.h"

namespace camrig::sensor {
namespace {

constexpr ImageSize size{640, 480};

TEST(NormalTables, SumAndDifferenceAreNormalAndHaveNothingToDoWithEachOther) {
    const NormalTables& tables = normal_tables();
    double squares = 0.0, fourths = 0.0, cross = 0.0, sum = 0.0;
    constexpr int n = NormalTables::size;
    for (std::size_t i = 0; i < n; ++i) {
        const double a = tables.a[i], b = tables.b[(i + 12345) % n];
        sum += a + b;
        squares += (a + b) * (a + b);
        fourths += std::pow(a + b, 4);
        cross += (a + b) * (a - b);
    }
    EXPECT_NEAR(sum / n, 0.0, 1e-3);
    EXPECT_NEAR(squares / n, 1.0, 0.01);
    EXPECT_NEAR(fourths / n, 3.0, 0.1);
    EXPECT_NEAR(cross / n, 0.0, 0.01);
}

TEST(NormalTables, NeighboursAreUncorrelated) {
    const NormalTables& tables = normal_tables();
    for (const auto* table : {&tables.a, &tables.b}) {
        for (std::size_t lag = 1; lag <= 4; ++lag) {
            double product = 0.0, squares = 0.0;
            for (std::size_t i = 0; i < NormalTables::size; ++i) {
                product += double{(*table)[i]} * (*table)[i + lag];
                squares += double{(*table)[i]} * (*table)[i];
            }
            EXPECT_NEAR(squares / NormalTables::size, 0.5, 1e-5);
            EXPECT_LT(std::abs(product / squares), 0.001) << lag;
        }
    }
}

TEST(Noise, IsWhiteInWidthHeightAndTime) {
    SensorSpec spec = plain_mono(1000.0);
    spec.read_noise_e = 3.0;
    const Sensor sensor = sensor_of(spec, size);
    for (const float level : {0.004f, 0.015f, 0.3f}) {  // all three ways of counting
        const GivenLight light(size, level);
        std::vector<Numbers> frames;
        for (int f = 0; f < 5; ++f) frames.push_back(taken(sensor, light.light(), {.frame = f}));
        const double mean = mean_of(frames[0]);
        double squares = 0.0, in_x[3]{}, in_y[3]{}, in_time[3]{};
        for (int y = 0; y + 3 < size.height; ++y) {
            for (int x = 0; x + 3 < size.width; ++x) {
                const auto at = [&](int f, int dx, int dy) {
                    return frames[static_cast<std::size_t>(f)]
                                 [static_cast<std::size_t>((y + dy) * size.width + x + dx)] -
                           mean;
                };
                const double here = at(0, 0, 0);
                squares += here * here;
                for (int lag = 1; lag <= 3; ++lag) {
                    in_x[lag - 1] += here * at(0, lag, 0);
                    in_y[lag - 1] += here * at(0, 0, lag);
                    in_time[lag - 1] += here * at(lag, 0, 0);
                }
            }
        }
        for (int lag = 0; lag < 3; ++lag) {
            EXPECT_LT(std::abs(in_x[lag] / squares), 0.01) << level;
            EXPECT_LT(std::abs(in_y[lag] / squares), 0.01) << level;
            EXPECT_LT(std::abs(in_time[lag] / squares), 0.01) << level;
        }
    }
}

TEST(Noise, FewElectronsArePoissonByChiSquare) {
    const SensorSpec spec = plain_mono(4095.0, 12);  // a number for each electron
    const Sensor sensor = sensor_of(spec, size);
    for (const double mean : {0.1, 0.5, 1.0, 2.0, 4.0, 7.9, 8.1, 12.0, 16.0, 19.9}) {
        const GivenLight light(size, static_cast<float>(mean / 4095.0));
        const Numbers numbers = taken(sensor, light.light(), {.frame = 3});
        std::vector<double> counts(80);
        for (const std::uint16_t number : numbers) ++counts.at(number);
        const auto n = static_cast<double>(numbers.size());
        double chi_square = 0.0, expected = 0.0, seen = 0.0, left = n;
        int cells = 0;
        for (int k = 0; k < 80; ++k) {
            const double p = n * std::exp(k * std::log(mean) - mean - std::lgamma(k + 1.0));
            expected += p, seen += counts[static_cast<std::size_t>(k)];
            left -= p;
            // Cells with fewer than 20 are joined with the next; what is left behind the last goes into it.
            if (expected < 20.0 || left < 20.0) continue;
            chi_square += (seen - expected) * (seen - expected) / expected;
            expected = seen = 0.0;
            ++cells;
        }
        expected += std::max(left, 0.0);
        chi_square += (seen - expected) * (seen - expected) / expected;
        // One in about ten thousand is above.
        EXPECT_LT(chi_square, cells + 4.0 * std::sqrt(2.0 * cells) + 6.0) << "mean " << mean << ", " << cells;
    }
}

TEST(Noise, ManyElectronsHaveMeanVarianceAndSkewnessOfPoisson) {
    for (const double mean : {20.0, 60.0, 1000.0}) {
        const SensorSpec spec = plain_mono(2000.0);
        const GivenLight light(size, static_cast<float>(mean / 2000.0));
        const Numbers numbers = taken(sensor_of(spec, size), light.light(), {.frame = 1});
        double moments[4]{};
        for (const std::uint16_t number : numbers) {
            const double off = number / spec.numbers_per_e() - mean;
            for (int i = 1; i < 4; ++i) moments[i] += std::pow(off, i) / static_cast<double>(numbers.size());
        }
        EXPECT_NEAR(moments[1], 0.0, 4.0 * std::sqrt(mean / static_cast<double>(numbers.size())));
        EXPECT_NEAR(moments[2] / mean, 1.0, 0.01);
        EXPECT_NEAR(moments[3] / std::pow(mean, 1.5), 1.0 / std::sqrt(mean), 0.02);
    }
}

TEST(Noise, RowsHaveAnOffsetOfTheirOwnInEachPicture) {
    SensorSpec spec = plain_mono(1000.0);
    spec.row_noise_e = 5.0;
    const Sensor sensor = sensor_of(spec, size);
    const GivenLight light(size, 0.5f);
    double squares = 0.0, between = 0.0;
    const auto row_e = [&](const Numbers& numbers, int y) {
        double sum = 0.0;
        for (int x = 0; x < size.width; ++x) sum += numbers[static_cast<std::size_t>(y * size.width + x)];
        return (sum / size.width - spec.black()) / spec.numbers_per_e() - 500.0;
    };
    const Numbers one = taken(sensor, light.light(), {.frame = 1}), two = taken(sensor, light.light(), {.frame = 2});
    for (int y = 0; y < size.height; ++y) {
        squares += row_e(one, y) * row_e(one, y) / size.height;
        between += row_e(one, y) * row_e(two, y) / size.height;
    }
    EXPECT_NEAR(std::sqrt(squares), std::sqrt(25.0 + 500.0 / size.width), 0.5);
    EXPECT_LT(std::abs(between / squares), 0.2);
}

TEST(Noise, HotPixelsStayPut) {
    SensorSpec spec = plain_mono(5000.0);
    spec.hot_pixels_ppm = 200.0;
    spec.hot_e_per_s = 2000.0;
    const Sensor sensor = sensor_of(spec, size);
    EXPECT_EQ(sensor.hot_pixels().size(), 61u);
    const GivenLight dark(size, 0.0f);
    for (const std::int64_t frame : {1, 2, 900}) {
        Numbers numbers = taken(sensor, dark.light(), {.frame = frame, .exposure_s = 0.5});
        for (const Sensor::HotPixel& hot : sensor.hot_pixels()) {
            const auto at = static_cast<std::size_t>(hot.y * size.width + hot.x);
            const double expected_e = std::min(hot.e_per_s * 0.5, 5000.0);
            EXPECT_NEAR(numbers[at] / spec.numbers_per_e(), expected_e, 6.0 * std::sqrt(expected_e) + 2.0);
            numbers[at] = 0;
        }
        EXPECT_EQ(*std::ranges::max_element(numbers), 0) << "nothing else is bright in the dark";
    }
    SensorSpec other = spec;
    other.seed = 8;
    const Sensor of_other = sensor_of(other, size);
    const auto place = [](const Sensor::HotPixel& hot) { return hot.y * size.width + hot.x; };
    EXPECT_FALSE(std::ranges::equal(of_other.hot_pixels(), sensor.hot_pixels(), {}, place, place));
}

TEST(Vignetting, IsTheCosineToTheFourth) {
    SensorSpec spec = plain_mono(1e6);
    spec.vignetting = 1.0;
    const auto k = *camera::intrinsics_from_vfov(size, 1.0);
    const GivenLight light(size, 0.9f);
    std::vector<double> sums(static_cast<std::size_t>(size.pixels()));
    const Numbers numbers = taken(sensor_of(spec, size), light.light(), {.frame = 1});
    for (const int y0 : {0, 236, 472}) {
        for (const int x0 : {0, 100, 316, 632}) {
            double sum = 0.0, expected = 0.0;
            for (int y = y0; y < y0 + 8; ++y) {
                for (int x = x0; x < x0 + 8; ++x) {
                    sum += numbers[static_cast<std::size_t>(y * size.width + x)];
                    const double angle = std::atan(std::hypot((x - k.cx) / k.fx, (y - k.cy) / k.fy));
                    expected += 0.9 * spec.max_number() * std::pow(std::cos(angle), 4);
                }
            }
            EXPECT_NEAR(sum / expected, 1.0, 0.005) << x0 << " " << y0;
        }
    }
}

TEST(Sensor, ExtremesGiveDefinedPictures) {
    constexpr ImageSize small{33, 17};
    for (const auto& preset : names_of(std::type_identity<SensorPreset>{})) {
        for (const double well_e : {100.0, 1e6}) {
            SensorSpec spec = sensor_preset(preset.value);
            spec.full_well_e = well_e;
            const Sensor sensor = sensor_of(spec, small);
            for (const double exposure_s : {1e-6, 10.0}) {
                for (const float level : {0.0f, -1.0f, 1e30f, std::numeric_limits<float>::infinity(),
                                          std::numeric_limits<float>::quiet_NaN()}) {
                    const GivenLight light(small, level);
                    const Shot shot{.frame = -5, .exposure_s = exposure_s, .gain_db = 48.0};
                    const Numbers numbers = taken(sensor, light.light(), shot);
                    EXPECT_EQ(numbers, taken(sensor, light.light(), shot));
                    EXPECT_LE(*std::ranges::max_element(numbers), spec.max_number());
                    if (level > 1.0f) {
                        EXPECT_GE(*std::ranges::min_element(numbers), spec.max_number() * 0.99) << preset.name;
                    } else if (preset.value == SensorPreset::ideal) {
                        EXPECT_EQ(*std::ranges::max_element(numbers), 0);
                    }
                }
            }
        }
    }
}

}  // namespace
}  // namespace camrig::sensor
