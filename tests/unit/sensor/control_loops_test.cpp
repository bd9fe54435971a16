// Automatic exposure and white balance over pictures that a sensor takes of given light.
#include <cmath>

#include <gtest/gtest.h>

#include "core/sensor/auto_exposure.h"
#include "core/sensor/auto_white_balance.h"
#include "tests/unit/sensor/flat_light.h"

namespace camrig::sensor {
namespace {

constexpr ImageSize size{63, 36};

/// Grey with highlights: of every 20 pixels one is four times as bright.
GivenLight scene(double level) {
    GivenLight light(size, static_cast<float>(level));
    for (auto& plane : light.values)
        for (std::size_t i = 0; i < plane.size(); i += 20) plane[i] *= 4.0f;
    return light;
}

SensorSpec mono() {
    return plain_mono(1e6);
}

/// Takes a picture as the loop says and lets it see the picture.
double take(AutoExposure& loop, const Sensor& sensor, const GivenLight& light, std::int64_t frame) {
    const ExposureSetting setting = loop.setting();
    const Numbers numbers =
        taken(sensor, light.light(), {.frame = frame, .exposure_s = setting.exposure_s, .gain_db = setting.gain_db});
    loop.advance(measure(sensor.spec(), size, numbers), {});
    return loop.measured();
}

TEST(AutoExposure, StepsOfLightAreFollowedInTheTimesOfTheTable) {
    const Sensor sensor = sensor_of(mono(), size);
    const struct {
        double factor;
        int frames;
    } table[] = {{1.0 / 16.0, 14}, {0.5, 10}, {2.0, 12}, {4.0, 17}, {16.0, 25}};
    for (const auto& step : table) {
        AutoExposure loop({.least_highlights = 0.0});
        constexpr double level = 0.25;
        std::int64_t frame = 0;
        while (frame < 30) take(loop, sensor, scene(level), frame++);
        ASSERT_TRUE(loop.is_locked());
        ASSERT_NEAR(loop.measured(), 0.16, 0.16 * 0.03);
        int settled = 0;
        for (int i = 0; i < 60; ++i)
            if (std::abs(take(loop, sensor, scene(level * step.factor), frame++) / 0.16 - 1.0) > 0.05) settled = i + 1;
        EXPECT_NEAR(settled, step.frames, 2) << "light times " << step.factor;
    }
}

TEST(AutoExposure, WhatAFrameSaysShowsAfterTwoMore) {
    const Sensor sensor = sensor_of(mono(), size);
    AutoExposure loop({});
    for (std::int64_t frame = 0; frame < 30; ++frame) take(loop, sensor, scene(0.25), frame);
    const ExposureSetting before = loop.setting();
    take(loop, sensor, scene(0.05), 30);
    EXPECT_EQ(loop.setting(), before);
    take(loop, sensor, scene(0.05), 31);
    EXPECT_EQ(loop.setting(), before);
    take(loop, sensor, scene(0.05), 32);
    EXPECT_GT(loop.setting().total_s(), 1.2 * before.total_s());
}

TEST(AutoExposure, ANewCameraIsRightAfterItsFirstFrames) {
    const Sensor sensor = sensor_of(mono(), size);
    AutoExposure loop({});
    for (std::int64_t frame = 0; frame < 9; ++frame) take(loop, sensor, scene(0.25), frame);
    EXPECT_NEAR(take(loop, sensor, scene(0.25), 9), 0.16, 0.16 * 0.03);
}

TEST(AutoExposure, ANewCameraThatSeesWhiteOnlyHurries) {
    const Sensor sensor = sensor_of(mono(), size);
    AutoExposure loop({.least_highlights = 0.0});
    for (std::int64_t frame = 0; frame < 11; ++frame) take(loop, sensor, scene(40.0), frame);
    EXPECT_NEAR(take(loop, sensor, scene(40.0), 11), 0.16, 0.16 * 0.05);
}

TEST(AutoExposure, HighlightsMakeADarkPictureBrighter) {
    const Sensor sensor = sensor_of(mono(), size);
    AutoExposure loop({});
    for (std::int64_t frame = 0; frame < 20; ++frame) take(loop, sensor, GivenLight(size, 0.2f), frame);
    EXPECT_NEAR(loop.measured(), 0.5, 0.02) << "all of it is the brightest";
}

TEST(AutoExposure, StaysWithinItsLimits) {
    const Sensor sensor = sensor_of(mono(), size);
    AutoExposure dark({.max_exposure_s = 0.04, .max_gain_db = 12.0}), bright({});
    for (std::int64_t frame = 0; frame < 50; ++frame) {
        take(dark, sensor, scene(1e-6), frame);
        take(bright, sensor, scene(1e6), frame);
    }
    EXPECT_NEAR(dark.setting().exposure_s, 0.04, 1e-9);
    EXPECT_NEAR(dark.setting().gain_db, 12.0, 1e-6);
    EXPECT_NEAR(bright.setting().exposure_s, 20e-6, 20e-6 * 0.02);
    EXPECT_NEAR(bright.setting().gain_db, 0.0, 1e-6);
}

TEST(AutoExposure, GainTakesOverWhereExposureEnds) {
    const Sensor sensor = sensor_of(mono(), size);
    AutoExposure loop({.max_exposure_s = 0.005});
    for (std::int64_t frame = 0; frame < 20; ++frame) take(loop, sensor, scene(0.1), frame);
    EXPECT_NEAR(loop.setting().exposure_s, 0.005, 1e-9);
    EXPECT_GT(loop.setting().gain_db, 6.0);
    EXPECT_NEAR(loop.measured(), 0.16, 0.16 * 0.03);
}

TEST(AutoExposure, EvadesFlickerByWholePeriods) {
    const Sensor sensor = sensor_of(mono(), size);
    for (const double hz : {50.0, 60.0}) {
        for (const double level : {0.003, 0.01, 0.03, 0.06, 5.0}) {
            AutoExposure loop({.flicker_hz = hz});
            for (std::int64_t frame = 0; frame < 20; ++frame) take(loop, sensor, scene(level), frame);
            const double periods = loop.setting().exposure_s * 2.0 * hz;
            if (level > 1.0) {
                EXPECT_LT(periods, 1.0);
            } else {
                EXPECT_NEAR(periods, std::round(periods), 1e-6) << hz << " Hz, light " << level;
                EXPECT_GE(periods, 0.99);
            }
            EXPECT_NEAR(loop.measured(), 0.16, 0.16 * 0.05) << hz << " Hz, light " << level;
        }
    }
}

FrameStatistics seen(const SensorSpec& spec, float red, float green, float blue, std::int64_t frame) {
    return measure(spec, size,
                   taken(sensor_of(spec, size), GivenLight(size, red, green, blue).light(), {.frame = frame}));
}

TEST(FrameStatistics, ZonesAndHighlightsAreMeans) {
    SensorSpec spec = mono();
    spec.black_level = 4096.0;
    GivenLight light = scene(0.1);
    const auto statistics = measure(spec, size, taken(sensor_of(spec, size), light.light(), {}));
    for (const auto& zone : statistics.zones) EXPECT_NEAR(zone[1], 0.1 * (1.0 + 3.0 / 20.0), 0.006);
    EXPECT_NEAR(statistics.highlights, 0.4, 0.004);
}

TEST(AutoWhiteBalance, ANewLightIsBalancedToNineteenTwentiethsAfter59Frames) {
    const SensorSpec spec = sensor_preset(SensorPreset::imx219);
    AutoWhiteBalance loop(spec, {});
    const auto red_gain = [&] { return loop.balance().gains[0] / loop.balance().gains[1]; };
    EXPECT_NEAR(red_gain() * spec.response_red, 1.0, 1e-9) << "begins neutral";
    std::int64_t frame = 0;
    while (frame < 12) loop.advance(seen(spec, 0.2f, 0.2f, 0.2f, frame++));
    const double before = red_gain(), after = before * 0.5;
    EXPECT_NEAR(before * spec.response_red, 1.0, 0.02);
    int frames = 0;
    for (; std::abs(red_gain() - after) > 0.05 * (before - after) && frames < 200; ++frames)
        loop.advance(seen(spec, 0.4f, 0.2f, 0.2f, frame++));
    EXPECT_NEAR(frames, 59, 3);
}

TEST(AutoWhiteBalance, DarkAndSaturatedZonesSayNothing) {
    const SensorSpec spec = sensor_preset(SensorPreset::imx219);
    AutoWhiteBalance loop(spec, {});
    const WhiteBalance before = loop.balance();
    for (std::int64_t frame = 0; frame < 5; ++frame) {
        loop.advance(seen(spec, 0.0f, 0.0f, 0.0f, frame));
        loop.advance(seen(spec, 9.0f, 9.0f, 9.0f, frame));
    }
    EXPECT_EQ(loop.balance(), before);
}

}  // namespace
}  // namespace camrig::sensor
