#include "core/world/route_path.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace camrig::world::route_path_test {
namespace {

TEST(RoutePath, ASquareWithRoundCornersHasItsKnownLength) {
    const Route square{.points = {{0, 0, 0}, {10, 0, 0}, {10, 10, 0}, {0, 10, 0}}, .closed = true};
    const auto path = RoutePath::create(square, 1.0).value();
    EXPECT_NEAR(path.length_m(), 4 * 8 + 2 * std::numbers::pi, 1e-12);
    EXPECT_NEAR(glm::distance(path.at(0).position, glm::dvec3(1, 0, 0)), 0, 1e-12);
    EXPECT_NEAR(path.at(8 + std::numbers::pi / 4).heading_rad, std::numbers::pi / 4, 1e-12);
}

TEST(RoutePath, PositionAndHeadingAreContinuousAndSpeedIsOne) {
    const Route route{.points = {{0, 0, 0}, {4, 0, 0}, {4.5, 3, 1}, {-1, 5, 0}, {-2, 0.3, 0}}, .closed = true};
    const auto path = RoutePath::create(route, 0.5).value();
    const double step = path.length_m() / 20000;
    auto before = path.at(0);
    for (int i = 1; i <= 20000; ++i) {
        const auto now = path.at(i * step);
        EXPECT_NEAR(glm::distance(now.position, before.position), step, step * 1e-2);
        EXPECT_LT(std::abs(std::remainder(now.heading_rad - before.heading_rad, 2 * std::numbers::pi)), 0.02);
        before = now;
    }
    EXPECT_LT(glm::distance(path.at(path.length_m()).position, path.at(0).position), 1e-9);
}

TEST(RoutePath, BadRoutesAreErrorsThatNameThePoint) {
    const auto message = [](Route route) { return RoutePath::create(route).error().message; };
    EXPECT_THAT(message({.points = {{0, 0, 0}}}), testing::HasSubstr("at least 2"));
    EXPECT_THAT(message({.points = {{0, 0, 0}, {1, 0, 0}}, .closed = true}), testing::HasSubstr("at least 3"));
    EXPECT_THAT(message({.points = {{0, 0, 0}, {0, 0, 5}}}), testing::HasSubstr("points[0]"));
    EXPECT_THAT(message({.points = {{0, 0, 0}, {1, 0, 0}, {0, 0, 0}}}), testing::HasSubstr("points[1]"));
}

}  // namespace
}  // namespace camrig::world::route_path_test
