#include "core/photo/plate_light.h"

#include <cmath>
#include <numbers>
#include <random>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/photo/sun.h"

namespace camrig::photo {
namespace {

using testing::HasSubstr;

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

TEST(Sun, AShadowTellsItsDirection) {
    PlateView view;
    view.k = {900, 900, 639.5, 359.5};
    view.position = {0, 0, 4};
    view.world_from_optical =
        camera::world_from_optical_rotation(*camera::pose_from_angles(view.position, {0, -15 * deg, 0}));
    const glm::dvec3 light = glm::normalize(glm::dvec3(0.4, 0.5, -0.6)), foot(12, -1, 0),
                     top = foot + glm::dvec3(0, 0, 2.2);
    const Shadow shadow{*view.project(top), *view.project(foot), *view.project(top - light * (top.z / light.z)), 0.0};
    const auto sun = sun_of_shadow(view, shadow);
    ASSERT_TRUE(sun) << sun.error().message;
    EXPECT_LT(glm::distance(sun->light_direction, light), 1e-9);
    EXPECT_NEAR(sun->height_m, 2.2, 1e-9);
    EXPECT_GT(sun->deviation_rad, 0.0005);
    EXPECT_LT(sun->deviation_rad, 0.05);
    Shadow sky = shadow;
    sky.tip_px.y = 10;
    EXPECT_THAT(sun_of_shadow(view, sky).error().message, HasSubstr("over the horizon"));
    Shadow down = shadow;
    down.top_px = shadow.foot_px + glm::dvec2(0, 30);
    EXPECT_THAT(sun_of_shadow(view, down).error().message, HasSubstr("not above the foot"));
}

TEST(PlateLight, LitAndShadedGroundGiveSunAndSky) {
    const glm::dvec3 direction = glm::normalize(glm::dvec3(1, 0, -1)), albedo(0.5, 0.4, 0.3);
    const glm::dvec3 sky(0.2, 0.25, 0.35), sun(1.1, 1.0, 0.8);
    const double sine = -direction.z;
    const glm::dvec3 total = sky + sine * sun;
    const auto light = match_light(albedo * total, albedo * sky, direction, 0.8 * total, 0.8);
    ASSERT_TRUE(light);
    for (int channel = 0; channel < 3; ++channel) {
        EXPECT_NEAR(light->sky[channel], sky[channel] / total[channel], 1e-12);
        EXPECT_NEAR(light->sky[channel] + sine * light->sun[channel], 1.0, 1e-12);
        // What is drawn of any surface is what the photo has of it.
        EXPECT_NEAR(light->gain[channel] * albedo[channel], albedo[channel] * total[channel], 1e-12);
    }
    EXPECT_FALSE(match_light(albedo * sky, albedo * total, direction, {}, 1.0));
    EXPECT_FALSE(match_light(albedo * total, albedo * sky, {1, 0, -0.01}, {}, 1.0));
}

struct Photo {
    std::vector<std::uint8_t> bytes;
    Picture picture;
};
template <typename Code>
Photo photo_of(ImageSize size, Code code) {
    Photo photo;
    for (int y = 0; y < size.height; ++y)
        for (int x = 0; x < size.width; ++x) {
            for (int channel = 0; channel < 3; ++channel)
                photo.bytes.push_back(std::uint8_t(std::clamp(std::lround(code(x, y, channel)), 0l, 255l)));
            photo.bytes.push_back(255);
        }
    photo.picture = {size, photo.bytes};
    return photo;
}

TEST(PlateLight, NoiseIsFoundBetweenTextures) {
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    for (const auto& [k, read] : {std::pair(0.02, 1.0), std::pair(0.0, 1.5), std::pair(0.03, 0.5)}) {
        const Photo photo = photo_of({640, 480}, [&](int x, int y, int) {
            // Steps of grey with slopes, and half of the columns are as rough as grass.
            const double level = 30 + 35 * (y / 80) + 0.05 * x;
            const double rough = (x / 32) % 2 ? 12.0 * normal(random) : 0.0;
            return level + rough + std::sqrt(k * level + read * read) * normal(random);
        });
        const auto noise = fit_noise(photo.picture);
        ASSERT_TRUE(noise);
        for (const double level : {50.0, 120.0, 200.0})
            EXPECT_NEAR(std::sqrt(noise->k * level + noise->read * noise->read), std::sqrt(k * level + read * read),
                        0.08 * std::sqrt(k * level + read * read))
                << k << " " << read << " at " << level;
    }
    std::uniform_int_distribution<int> any(0, 255);
    EXPECT_FALSE(fit_noise(photo_of({64, 64}, [&](int, int, int) { return 255.0; }).picture));
}

double code_of(double linear) {
    return 255.0 * (linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055);
}

TEST(PlateLight, TheSoftnessOfAnEdgeComesOutAsPutIn) {
    for (const double sigma : {0.5, 0.8, 1.4})
        for (const double turn : {0.1, 1.3, 3.0}) {
            const auto at = [&](double x, double y) {
                const double s = (x - 20) * std::cos(turn) + (y - 20) * std::sin(turn);
                return 0.1 + 0.5 * 0.5 * std::erfc(-s / (sigma * std::numbers::sqrt2));
            };
            const Photo photo = photo_of({41, 41}, [&](int x, int y, int) {
                double sum = 0.0;  // the mean over the pixel's area
                for (int i = 0; i < 8; ++i)
                    for (int j = 0; j < 8; ++j) sum += at(x + (i - 3.5) / 8, y + (j - 3.5) / 8);
                return code_of(sum / 64);
            });
            const auto edge = fit_edge(photo.picture, {0, 0, 41, 41});
            ASSERT_TRUE(edge) << sigma << " " << turn << edge.error().message;
            EXPECT_NEAR(*edge, sigma, 0.04) << turn;
        }
    const auto plain = photo_of({41, 41}, [](int, int, int) { return 90.0; });
    EXPECT_THAT(fit_edge(plain.picture, {0, 0, 41, 41}).error().message, HasSubstr("not one straight edge"));
    const auto corner = photo_of({41, 41}, [](int x, int y, int) { return x > 20 && y > 20 ? 200.0 : 60.0; });
    EXPECT_FALSE(fit_edge(corner.picture, {0, 0, 41, 41}));
    EXPECT_THAT(fit_edge(corner.picture, {20, 0, 41, 41}).error().message, HasSubstr("not within the photo"));
}

TEST(PlateLight, ARegionThatIsClippedIsRefused) {
    const auto white = photo_of({20, 20}, [](int x, int, int) { return x < 10 ? 255.0 : 100.0; });
    EXPECT_THAT(mean_light(white.picture, {0, 0, 20, 20}).error().message, HasSubstr("is clipped"));
    EXPECT_NEAR(mean_light(white.picture, {10, 0, 10, 20})->x, linear_of(100), 1e-12);
}

}  // namespace
}  // namespace camrig::photo
