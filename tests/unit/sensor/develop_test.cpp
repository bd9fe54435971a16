#include "core/sensor/develop.h"

#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/sensor/flat_light.h"

namespace camrig::sensor {
namespace {

using Picture = std::vector<std::uint32_t>;

Picture developed(const SensorSpec& spec, ImageSize size, const Numbers& numbers, const WhiteBalance& balance,
                  bool wide = has_wide_rows()) {
    Picture picture(static_cast<std::size_t>(size.pixels()));
    develop(spec, size, numbers, balance, 0, size.height, {picture.data(), size.width}, wide);
    return picture;
}

int channel(std::uint32_t pixel, int c) {
    return static_cast<int>(pixel >> (8 * c) & 0xff);
}

double srgb_code(double light) {
    return 255.0 * (light <= 0.0031308 ? 12.92 * light : 1.055 * std::pow(light, 1.0 / 2.4) - 0.055);
}

/// Numbers as a sensor without noise would give them.
Numbers mosaic(ColorFilter filter, ImageSize size, std::uint16_t red, std::uint16_t green, std::uint16_t blue) {
    const std::string name(to_string(filter));
    Numbers numbers;
    for (int y = 0; y < size.height; ++y) {
        for (int x = 0; x < size.width; ++x) {
            const char color = name[static_cast<std::size_t>((y & 1) * 2 + (x & 1))];
            numbers.push_back(color == 'r' ? red : color == 'g' ? green : blue);
        }
    }
    return numbers;
}

TEST(Develop, TheIdealSensorShowsLightAsSrgb) {
    constexpr ImageSize size{256, 16};
    SensorSpec spec = sensor_preset(SensorPreset::ideal);
    spec.full_well_e = 1e6;
    GivenLight light(size, 0.0f);
    for (std::size_t i = 0; i < light.values[0].size(); ++i)
        for (auto& plane : light.values) plane[i] = static_cast<float>(i % 256) / 255.0f;
    const auto picture = developed(spec, size, taken(sensor_of(spec, size), light.light(), {}), {});
    for (std::size_t i = 0; i < picture.size(); ++i) {
        const double level = static_cast<double>(i % 256) / 255.0;
        // Shot noise of a million electrons, five times.
        EXPECT_NEAR(channel(picture[i], 1), srgb_code(level), 0.55 + 1.3 * std::pow(level, 1.0 / 2.4 - 0.5)) << i;
        EXPECT_EQ(channel(picture[i], 3), 255);
    }
}

TEST(Develop, AMosaicOfOneColourIsThatColourToTheEdges) {
    constexpr ImageSize size{19, 14};
    for (const ColorFilter filter : {ColorFilter::rggb, ColorFilter::grbg, ColorFilter::gbrg, ColorFilter::bggr}) {
        SensorSpec spec;
        spec.filter = filter;
        spec.bits = 12;
        spec.black_level = 256.0;
        const double range = 4095.0 - 256.0;
        for (const auto pixel : developed(spec, size, mosaic(filter, size, 1000, 2000, 3000), {{2.0, 1.0, 1.25}})) {
            EXPECT_NEAR(channel(pixel, 0), srgb_code(2.0 * 744.0 / range), 0.55);
            EXPECT_NEAR(channel(pixel, 1), srgb_code(1744.0 / range), 0.55);
            EXPECT_NEAR(channel(pixel, 2), srgb_code(1.25 * 2744.0 / range), 0.55);
        }
    }
}

TEST(Develop, TheSensorMakesTheMosaicThatItsNameSays) {
    constexpr ImageSize size{18, 6};
    for (const ColorFilter filter : {ColorFilter::rggb, ColorFilter::grbg, ColorFilter::gbrg, ColorFilter::bggr}) {
        SensorSpec spec;
        spec.filter = filter;
        spec.full_well_e = 1e6;
        const Numbers numbers = taken(sensor_of(spec, size), GivenLight(size, 0.2f, 0.5f, 0.8f).light(), {.frame = 2});
        const Numbers expected = mosaic(filter, size, 13107, 32768, 52428);
        for (std::size_t i = 0; i < numbers.size(); ++i) EXPECT_NEAR(numbers[i], expected[i], 0.01 * expected[i]);
    }
}

TEST(Develop, InterpolatedColoursFollowARamp) {
    constexpr ImageSize size{32, 32};
    SensorSpec spec;
    spec.filter = ColorFilter::rggb;
    Numbers numbers;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) numbers.push_back(static_cast<std::uint16_t>(1000 * x + 300 * y));
    const auto picture = developed(spec, size, numbers, {});
    for (int y = 1; y + 1 < size.height; ++y)
        for (int x = 1; x + 1 < size.width; ++x)
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(channel(picture[static_cast<std::size_t>(y * size.width + x)], c),
                            srgb_code((1000.0 * x + 300.0 * y) / 65535.0), 0.55);
}

TEST(Develop, WhatIsSaturatedIsWhite) {
    constexpr ImageSize size{16, 16};
    const SensorSpec spec = sensor_preset(SensorPreset::imx219);
    const GivenLight light(size, 50.0f);
    const auto numbers = taken(sensor_of(spec, size), light.light(), {});
    for (const auto pixel : developed(spec, size, numbers, WhiteBalance::of_kelvin(spec, 6500.0)))
        EXPECT_EQ(pixel, 0xffffffffu);
}

TEST(Develop, KelvinUndoesTheFilters) {
    const SensorSpec spec = sensor_preset(SensorPreset::imx477);
    const auto neutral = WhiteBalance::of_kelvin(spec, 6500.0).gains;
    EXPECT_NEAR(neutral[0] * spec.response_red, neutral[1], 1e-9);
    EXPECT_NEAR(neutral[2] * spec.response_blue, neutral[1], 1e-9);
    const auto warm = WhiteBalance::of_kelvin(spec, 2800.0).gains;
    EXPECT_GT(warm[2] / warm[0], neutral[2] / neutral[0]) << "in warm light red is weakened";
}

TEST(Develop, GivesTheSameBytesByRowsAndWithoutWideVectors) {
    constexpr ImageSize size{75, 33};
    for (const SensorPreset preset : {SensorPreset::imx219, SensorPreset::imx249, SensorPreset::ideal}) {
        const SensorSpec spec = sensor_preset(preset);
        const Numbers numbers = taken(sensor_of(spec, size), GivenLight(size, 0.4f).light(), {.frame = 5});
        const WhiteBalance balance{{1.9, 1.0, 1.4}};
        const Picture whole = developed(spec, size, numbers, balance);
        EXPECT_EQ(whole, developed(spec, size, numbers, balance, false));
        Picture parts(whole.size());
        for (const auto& [first, end] : {std::pair{20, 33}, {0, 3}, {3, 20}})
            develop(spec, size, numbers, balance, first, end, {parts.data(), size.width});
        EXPECT_EQ(whole, parts);
    }
}

}  // namespace
}  // namespace camrig::sensor
