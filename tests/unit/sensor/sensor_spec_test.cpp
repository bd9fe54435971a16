#include "core/sensor/sensor_spec.h"

#include <gtest/gtest.h>

#include "core/base/field_of.h"
#include "tests/unit/sensor/flat_light.h"

namespace camrig::sensor {
namespace {

TEST(SensorSpec, APresetSetsAllAndWhatIsGivenBesideItCounts) {
    const auto spec = read_all<SensorSpec>(
        nlohmann::json{{"read_noise_e", 9}, {"preset", "imx477"}, {"exposure_s", "auto"}, {"seed", 5u}}, "sensor");
    ASSERT_TRUE(spec.has_value()) << spec.error().message;
    EXPECT_EQ(spec->full_well_e, 8560.0);
    EXPECT_EQ(spec->filter, ColorFilter::rggb);
    EXPECT_EQ(spec->read_noise_e, 9.0);
    EXPECT_EQ(spec->exposure_s, std::nullopt);
    EXPECT_EQ(spec->seed, 5u);
}

TEST(SensorSpec, ExposuresTakeAsManyPeriodsAsTheyBeginWhereTheRateMayFall) {
    SensorSpec spec;
    const Rate rate = Rate::parse("30000/1001").value();
    EXPECT_EQ(spec.periods_of(10.0, rate), 1) << "it may not";
    EXPECT_DOUBLE_EQ(spec.longest_exposure_s(Rate()), 0.04);
    spec.dynamic_framerate = true;
    EXPECT_DOUBLE_EQ(spec.longest_exposure_s(Rate()), 0.2);
    EXPECT_DOUBLE_EQ(spec.longest_exposure_s(Rate::parse("2").value()), 0.5);
    for (const auto& [exposure_s, periods] :
         {std::pair(1e-6, 1), {0.04, 1}, {0.0400005, 1}, {0.040002, 2}, {0.08, 2}, {0.2, 5}, {10.0, 250}})
        EXPECT_EQ(spec.periods_of(exposure_s, Rate()), periods) << exposure_s;
    EXPECT_EQ(spec.periods_of(4.0 / 120.0, rate), 1) << "four half periods of 60 Hz";
    EXPECT_EQ(spec.periods_of(0.2, Rate::parse("30").value()), 6) << "which are 199 999 998 ns";
}

TEST(SensorSpec, WhatIsWrittenReadsAsTheSame) {
    for (const auto& preset : names_of(std::type_identity<SensorPreset>{})) {
        SensorSpec spec = sensor_preset(preset.value);
        spec.lux = 300.0;
        const auto read = read_all<SensorSpec>(json_of(spec), "sensor");
        ASSERT_TRUE(read.has_value()) << read.error().message;
        EXPECT_EQ(*read, spec);
    }
}

TEST(SensorSpec, ErrorsNameFieldAndRange) {
    const auto message = [](const nlohmann::json& json) {
        const auto read = read_all<SensorSpec>(json, "sensor");
        return read ? std::string() : read.error().message;
    };
    EXPECT_EQ(message({{"exposure_s", 20}}), "sensor.exposure_s: must be 1e-6 to 10 s");
    EXPECT_EQ(message({{"full_well_e", 1}}), "sensor.full_well_e: must be 100 to 1e6 e");
    EXPECT_EQ(message({{"bits", 17}}), "sensor.bits: must be 8 to 16");
    SensorSpec spec;
    spec.bits = 8;
    spec.black_level = 100.0;
    const auto made = Sensor::create(spec, {64, 64}, {});
    ASSERT_FALSE(made.has_value());
    EXPECT_EQ(made.error().message, "black_level: must be at most 64, a quarter of the range of 8 bits");
}

/// libcamera's tuning files say how bright a picture is at which illuminance, from which electrons follow: of an
/// 18 % grey scene 34 e per lux second (imx219) and 103 (imx477, with a lens of its own).
TEST(SensorSpec, LuxGivesTheElectronsThatWereMeasured) {
    SensorSpec spec = sensor_preset(SensorPreset::imx219);
    spec.lux = 1.0;
    EXPECT_NEAR(0.18 * spec.electrons_per_s(), 34.0, 1.0);
    spec.lux.reset();
    EXPECT_DOUBLE_EQ(spec.electrons_per_s() * 0.01, spec.full_well_e);
}

}  // namespace
}  // namespace camrig::sensor
