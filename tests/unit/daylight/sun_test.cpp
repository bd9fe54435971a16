#include "core/daylight/sun.h"

#include <numbers>

#include <gtest/gtest.h>

namespace camrig::daylight {
namespace {

constexpr double deg = std::numbers::pi / 180.0;

// The example of Reda and Andreas, Solar Position Algorithm (NREL/TP-560-34302, 2008), table A5.1. Checked against the
// results that NREL's spa_tester.c lists (azimuth 194.340241, zenith 50.111622 with refraction), and against the steps
// of it in pvlib-python's pvlib/tests/test_spa.py: elevation without refraction (e0) 39.872046, refraction (de)
// 0.016332.
TEST(Sun, StandsWhereNrelsExampleHasIt) {
    const auto at = read_instant("2003-10-17T12:30:30-07:00");
    ASSERT_TRUE(at);
    const SunPlace sun = sun_at(*at, 39.742476, -105.1786);
    EXPECT_NEAR(sun.azimuth / deg, 194.340241, 0.01);
    EXPECT_NEAR(sun.elevation / deg, 39.872046, 0.01);
}

// Meeus, Astronomical Algorithms, example 25.a: declination -7.78507 degrees, 1992-10-13 0h TD; checked against tests
// of other libraries that cite it. At the pole the sun's elevation is its declination.
TEST(Sun, HasTheDeclinationOfMeeusExample) {
    const SunPlace sun = sun_at(*read_instant("1992-10-13T00:00:00Z") - 59.0, 90.0, 0.0);
    EXPECT_NEAR(sun.elevation / deg, -7.78507, 0.001);
}

TEST(Sun, TimesAreReadAndOthersRefused) {
    EXPECT_EQ(*read_instant("1970-01-02T00:00Z"), 86400.0);
    EXPECT_EQ(*read_instant("2000-01-01T02:00:00+02:00"), 946684800.0);
    for (const char* text : {"", "2000-01-01", "2000-13-01T00:00Z", "2000-02-30T00:00Z", "2000-01-01T24:00Z",
                             "2000-01-01T00:00", "2000-01-01T00:00:99Z", "2000-01-01T00:00Zx", "2000-01-01T00:00+2"})
        EXPECT_FALSE(read_instant(text)) << text;
}

TEST(Sun, AzimuthRunsFromNorthThroughEast) {
    const double north = 90 * deg;  // y
    const glm::dvec3 morning = light_direction({90 * deg, 0.0}, north);
    EXPECT_LT(glm::distance(morning, glm::dvec3(-1, 0, 0)), 1e-12) << "from the east: travels west";
    const SunPlace back = sun_of(light_direction({200 * deg, 35 * deg}, 20 * deg), 20 * deg);
    EXPECT_NEAR(back.azimuth / deg, 200, 1e-9);
    EXPECT_NEAR(back.elevation / deg, 35, 1e-9);
}

}  // namespace
}  // namespace camrig::daylight
