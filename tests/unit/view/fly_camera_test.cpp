#include "tools/view/fly_camera.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

constexpr double quarter = std::numbers::pi / 2;

TEST(FlyCamera, GoesAlongItsSightToItsLeftAndUpTheWorld) {
    FlyCamera fly{.position = {1, 2, 3}, .pan_rad = quarter, .tilt_rad = 0};  // looks along +y
    fly.go(2, 0, 0);
    EXPECT_NEAR(glm::length(fly.position - glm::dvec3(1, 4, 3)), 0, 1e-12);
    fly.go(0, 1, 0.5);  // its left is -x
    EXPECT_NEAR(glm::length(fly.position - glm::dvec3(0, 4, 3.5)), 0, 1e-12);
    fly.tilt_rad = -quarter / 2;
    fly.go(std::numbers::sqrt2, 0, 0);
    EXPECT_NEAR(glm::length(fly.position - glm::dvec3(0, 5, 2.5)), 0, 1e-12);
}

TEST(FlyCamera, ADragToTheRightTurnsLeftSoThatTheWorldFollowsTheMouse) {
    FlyCamera fly;
    fly.drag({100, 50}, 500);
    EXPECT_NEAR(fly.pan_rad, 0.2, 1e-12);
    EXPECT_NEAR(fly.tilt_rad, 0.1, 1e-12);
    fly.drag({0, 1e6}, 500);
    EXPECT_EQ(fly.tilt_rad, FlyCamera::max_tilt_rad);
    fly.drag({-1e6, 0}, 500);
    EXPECT_LE(std::abs(fly.pan_rad), std::numbers::pi);
}

TEST(FlyCamera, TakesThePlaceOfACameraWithoutItsRoll) {
    const auto pose = camera::pose_from_angles({4, 5, 6}, {.pan = 1, .tilt = -0.5, .roll = 0.7}).value();
    const FlyCamera fly = FlyCamera::at(pose);
    EXPECT_NEAR(fly.pan_rad, 1, 1e-12);
    EXPECT_NEAR(fly.tilt_rad, -0.5, 1e-12);
    EXPECT_EQ(fly.pose().position, pose.position);
    EXPECT_NEAR(camera::angles_of(fly.pose().orientation).roll, 0, 1e-12);
}

}  // namespace
}  // namespace camrig::view
