#include "core/daylight/sky.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::daylight {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

glm::dvec3 at_elevation(double degrees) {
    return {std::cos(degrees * degree), 0.0, std::sin(degrees * degree)};
}
double lux(const glm::dvec3& rgb) {
    return glm::dot(rgb, glm::dvec3(0.2126, 0.7152, 0.0722));
}
double level_lux(const Sky& sky, double elevation_deg) {
    return lux(sky.sky_lux()) + lux(sky.sun_lux()) * std::max(0.0, std::sin(elevation_deg * degree));
}

// What twilight is said to be: half a day's readings of the literature, to the accuracy that they agree among
// themselves (Seidelmann, Explanatory Supplement to the Astronomical Almanac, 1992, section 9.5).
TEST(Sky, GivesLevelGroundWhatIsMeasuredThere) {
    const Air clear;
    EXPECT_NEAR(level_lux({at_elevation(90), clear}, 90), 129e3, 2e3);
    EXPECT_NEAR(level_lux({at_elevation(30), clear}, 30), 46e3, 1e3);
    EXPECT_NEAR(level_lux({at_elevation(0), clear}, 0), 760, 10) << "the sun's middle on the horizon";
    EXPECT_NEAR(level_lux({at_elevation(-6), clear}, -6), 3.4, 0.2) << "end of civil twilight";
    EXPECT_NEAR(level_lux({at_elevation(-12), clear}, -12), 0.0081 + 0.002, 1e-3) << "nautical";
    EXPECT_NEAR(level_lux({at_elevation(-40), clear}, -40), 0.002, 1e-6) << "stars";
}

TEST(Sky, IsSteadyWhereItsPiecesMeet) {
    for (const double edge : {20.0, 5.0, -0.8, -5.0, -12.0}) {
        const double above = level_lux({at_elevation(edge + 1e-6), {}}, edge);
        const double below = level_lux({at_elevation(edge - 1e-6), {}}, edge);
        EXPECT_NEAR(above / below, 1.0, 0.012) << edge;
    }
}

TEST(Sky, TheSunIsWeakerAndRedderTheLowerItStands) {
    double last_lux = 1e9, last_blue = 1e9;
    for (const double elevation : {80.0, 40.0, 20.0, 10.0, 4.0, 1.0}) {
        const glm::dvec3 sun = Sky(at_elevation(elevation), {}).sun_lux();
        EXPECT_LT(lux(sun), last_lux) << elevation;
        EXPECT_LT(sun.b / sun.r, last_blue) << elevation;
        last_lux = lux(sun);
        last_blue = sun.b / sun.r;
    }
    // ESRA and most tables: 95 to 100 klx at 60 degrees in clear air.
    EXPECT_NEAR(lux(Sky(at_elevation(60), {.turbidity = 2.7}).sun_lux()), 97e3, 4e3);
    EXPECT_EQ(lux(Sky(at_elevation(-0.3), {}).sun_lux()), 0.0);
}

TEST(Sky, ItsLightFromAllSidesIsWhatLevelGroundHas) {
    for (const double overcast : {0.0, 0.4, 1.0}) {
        const Sky sky(at_elevation(35), {.turbidity = 4.0, .overcast = overcast});
        glm::dvec3 sum(0.0);
        constexpr int rows = 60, columns = 120;
        for (int row = 0; row < rows; ++row)
            for (int column = 0; column < columns; ++column) {
                const double zenith = 0.5 * std::numbers::pi * (row + 0.5) / rows;
                const double pan = 2.0 * std::numbers::pi * (column + 0.5) / columns;
                const glm::dvec3 towards(std::sin(zenith) * std::cos(pan), std::sin(zenith) * std::sin(pan),
                                         std::cos(zenith));
                sum += sky.from(towards) * std::cos(zenith) * std::sin(zenith);
            }
        // Over the half sphere, cosine over pi.
        sum *= 0.5 * std::numbers::pi / rows * 2.0 / columns;
        for (int channel = 0; channel < 3; ++channel)
            EXPECT_NEAR(sum[channel] / sky.sky_lux()[channel], 1.0, 0.01) << overcast << " " << channel;
    }
}

TEST(Sky, IsBlueOverheadAndPaleAtTheHorizon) {
    const Sky sky(at_elevation(45), {.turbidity = 2.5});
    const glm::dvec3 overhead = sky.from({-std::sin(0.6), 0.0, std::cos(0.6)});
    const glm::dvec3 low = sky.from({-std::cos(0.05), 0.0, std::sin(0.05)});
    EXPECT_GT(overhead.b / overhead.r, 2.0);
    EXPECT_LT(low.b / low.r, 0.8 * overhead.b / overhead.r);
    EXPECT_GT(lux(low), 1.5 * lux(overhead));
}

// CIE overcast sky: the zenith is three times as bright as the horizon, and all of it grey.
TEST(Sky, CloudsHideTheSunAndAreBrightestOverhead) {
    const Sky sky(at_elevation(60), {.overcast = 1.0});
    EXPECT_EQ(lux(sky.sun_lux()), 0.0);
    EXPECT_NEAR(lux(sky.sky_lux()), 300.0 + 21000.0 * std::sin(60 * degree), 1.0);
    EXPECT_NEAR(sky.from({0, 0, 1}).g / sky.from({1, 0, 0}).g, 3.0, 1e-9);
    EXPECT_EQ(sky.from({0, 0, 1}).r, sky.from({0, 0, 1}).b);
    EXPECT_LT(level_lux({at_elevation(-4), {.overcast = 1.0}}, -4), level_lux({at_elevation(-4), {}}, -4));
}

TEST(Sky, IsDefinedWhereverTheSunIs) {
    for (double elevation = -90.0; elevation <= 90.0; elevation += 1.5)
        for (const double turbidity : {-5.0, 2.0, 6.0, 10.0, 99.0})
            for (const double overcast : {-1.0, 0.0, 0.5, 2.0}) {
                const Sky sky(at_elevation(elevation), {.turbidity = turbidity, .overcast = overcast});
                for (const glm::dvec3& value :
                     {sky.sun_lux(), sky.sky_lux(), sky.from({0, 0, 1}), sky.from({1, 0, 0}), sky.from({-1, 0, 0})})
                    for (int channel = 0; channel < 3; ++channel)
                        ASSERT_TRUE(value[channel] >= 0.0 && value[channel] < 1e7)
                            << elevation << " " << turbidity << " " << overcast;
            }
}

}  // namespace
}  // namespace camrig::daylight
