// The same numbers whoever makes which rows, with whatever vectors.
#include <thread>

#include <gtest/gtest.h>

#include "core/sensor/row_loops.h"
#include "tests/unit/sensor/flat_light.h"

namespace camrig::sensor {
namespace {

constexpr ImageSize size{333, 65};

/// From none to more than a well, so that every way of counting is there in one row.
GivenLight ramp() {
    GivenLight light(size, 0.0f);
    for (std::size_t c = 0; c < 3; ++c) {
        for (std::size_t i = 0; i < light.values[c].size(); ++i) {
            const auto x = static_cast<float>(i % static_cast<std::size_t>(size.width));
            light.values[c][i] = x < 200.0f ? 2e-5f * x : 0.01f * (x - 199.0f);
        }
    }
    return light;
}

TEST(SameNumbers, HoweverRowsAreSharedOut) {
    const GivenLight light = ramp();
    for (const auto& preset : names_of(std::type_identity<SensorPreset>{})) {
        const Sensor sensor = sensor_of(sensor_preset(preset.value), size);
        const Shot shot{.frame = 11};
        const Numbers whole = taken(sensor, light.light(), shot);
        Numbers parts(sensor.count());
        {
            std::vector<std::jthread> threads;
            for (const auto& [first, end] : {std::pair{40, 65}, {0, 7}, {7, 8}, {8, 40}})
                threads.emplace_back([&, first, end] { sensor.expose(light.light(), shot, first, end, parts); });
        }
        EXPECT_EQ(whole, parts) << preset.name;
    }
}

TEST(SameNumbers, WithAndWithoutWideVectors) {
    const GivenLight light = ramp();
    for (const auto& preset : names_of(std::type_identity<SensorPreset>{})) {
        const Sensor sensor = sensor_of(sensor_preset(preset.value), size);
        Numbers wide(sensor.count()), plain(sensor.count());
        sensor.expose(light.light(), {.frame = 4}, 0, size.height, wide, has_wide_rows());
        sensor.expose(light.light(), {.frame = 4}, 0, size.height, plain, false);
        EXPECT_EQ(wide, plain) << preset.name;
    }
}

/// The same formulas as this file's compiler flags make of them, by twos.
TEST(SameNumbers, CompiledOtherwise) {
    RowExposure row;
    row.padded_width = 320;
    row.electrons = 300.0f;
    row.u0 = -0.6f, row.u_step = 1.0f / 260.0f, row.v2 = 0.04f;
    row.prnu = 0.01f, row.dark_e = 0.1f;
    row.limit_e = 20'000.0f, row.full_well_e = 10'000.0f;
    row.read_noise_e = 3.0f, row.dsnu_e = 1.0f, row.row_e = 0.3f;
    row.numbers_per_e = 0.41f, row.black = 256.0f, row.max_number = 4095.0f;
    row.fixed = RowNoise::of(1, RowNoise::Purpose::fixed_pattern, 0, 0, 9);
    std::vector<float> light(320), mean(320), mean_here(320);
    for (std::size_t x = 0; x < 320; ++x)
        light[x] = x < 160 ? 0.0007f * static_cast<float>(x) : static_cast<float>(x - 159);
    Numbers made(320), made_here(320);
    for (int frame = 0; frame < 50; ++frame) {
        row.noise = RowNoise::of(1, RowNoise::Purpose::picture, 0, frame, 9);
        expect_electrons(row, light.data(), mean.data(), has_wide_rows());
        count_electrons(row, mean.data(), made.data(), has_wide_rows());
        RowLoops<TwoLanes>::expect_electrons(row, light.data(), mean_here.data());
        RowLoops<TwoLanes>::count_electrons(row, mean_here.data(), made_here.data());
        ASSERT_EQ(mean, mean_here);
        ASSERT_EQ(made, made_here);
    }
}

TEST(SameNumbers, OfLightThatStandsButInSomeTiles) {
    const GivenLight standing = ramp(), other(size, 0.02f, 0.3f, 7.0f);
    TileSet tiles;
    tiles.clear(size);
    std::vector<PixelRect> parts;
    for (const PixelRect& rect : {PixelRect{0, 0, 5, 9}, {99, 20, 240, 21}, {200, 9, 200, 60}, {320, 30, 333, 65}})
        tiles.mark(rect, parts);
    GivenLight seen = standing;
    for (const PixelRect& part : parts)
        for (int y = part.y0; y < part.y1; ++y)
            for (int x = part.x0; x < part.x1; ++x)
                for (std::size_t c = 0; c < 3; ++c) {
                    const auto i = static_cast<std::size_t>(y * size.width + x);
                    seen.values[c][i] = other.values[c][i];
                }
    for (const auto& preset : names_of(std::type_identity<SensorPreset>{})) {
        const Sensor sensor = sensor_of(sensor_preset(preset.value), size);
        SiteLight sites;
        sites.fit(sensor.spec(), size);
        sensor.gather(standing.light(), 0, 33, sites);
        sensor.gather(standing.light(), 33, size.height, sites);
        Numbers made(sensor.count());
        sensor.expose({&sites, &tiles}, other.light(), {.frame = 4}, 0, size.height, made);
        EXPECT_EQ(made, taken(sensor, seen.light(), {.frame = 4})) << preset.name;
    }
}

TEST(SameNumbers, DifferWithSeedAndFrame) {
    const GivenLight light(size, 0.3f);
    SensorSpec spec = sensor_preset(SensorPreset::imx477);
    const Numbers first = taken(sensor_of(spec, size), light.light(), {.frame = 1});
    EXPECT_NE(first, taken(sensor_of(spec, size), light.light(), {.frame = 2}));
    spec.seed = 1;
    EXPECT_NE(first, taken(sensor_of(spec, size), light.light(), {.frame = 1}));
}

}  // namespace
}  // namespace camrig::sensor
