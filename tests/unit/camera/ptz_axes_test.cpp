#include "core/camera/ptz_axes.h"

#include <cmath>

#include <glm/trigonometric.hpp>
#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::camera {
namespace {

Pose base_of(double pan_deg, double tilt_deg, double roll_deg = 0.0) {
    return pose_from_angles({1, 2, 3}, {glm::radians(pan_deg), glm::radians(tilt_deg), glm::radians(roll_deg)}).value();
}

PanTiltRoll angles_at(const Pose& base, double pan_deg, double tilt_deg) {
    return angles_of(turned_by(base, {pan_deg, tilt_deg, 1.0}).orientation);
}

TEST(PtzAxes, AHeadThatLooksDownKeepsItsHorizonLevelAsItPansAndTilts) {
    const Pose base = base_of(20.0, -30.0);
    for (const double pan : {-170.0, -90.0, 0.0, 33.0, 90.0, 180.0})
        for (const double tilt : {-55.0, 0.0, 70.0}) {
            const Pose turned = turned_by(base, {pan, tilt, 1.0});
            // The link's y points to the left of the picture.
            EXPECT_NEAR((turned.orientation * glm::dvec3(0, 1, 0)).z, 0.0, 1e-15) << pan << " " << tilt;
            const PanTiltRoll angles = angles_of(turned.orientation);
            EXPECT_NEAR(std::remainder(glm::degrees(angles.pan) - 20.0 - pan, 360.0), 0.0, 1e-12);
            EXPECT_NEAR(glm::degrees(angles.tilt), -30.0 + tilt, 1e-12);
            EXPECT_EQ(turned.position, base.position);
        }
}

TEST(PtzAxes, RollStaysWhatItIsInTheBase) {
    for (const double roll : {-120.0, 15.0, 90.0, 180.0}) {
        const PanTiltRoll angles = angles_at(base_of(20.0, -30.0, roll), 90.0, 10.0);
        EXPECT_NEAR(std::remainder(glm::degrees(angles.roll) - roll, 360.0), 0.0, 1e-12);
        EXPECT_NEAR(glm::degrees(angles.tilt), -20.0, 1e-12);
        EXPECT_NEAR(glm::degrees(angles.pan), 110.0, 1e-12);
    }
}

TEST(PtzAxes, AtPanAndTiltZeroItIsTheBaseToTheLastBit) {
    for (std::uint64_t n = 0; n < 1000; ++n) {
        const Pose base =
            base_of(360.0 * random_unit(1, 0, n), 180.0 * random_unit(1, 1, n) - 90.0, 360.0 * random_unit(1, 2, n));
        EXPECT_EQ(turned_by(base, {}), base);
        // And comes there without a jump.
        const glm::dquat& near = turned_by(base, {1e-9, -1e-9, 1.0}).orientation;
        EXPECT_NEAR(std::abs(glm::dot(near, base.orientation)), 1.0, 1e-14);
    }
}

TEST(PtzAxes, PastStraightDownAHeadThatFlipsHasUpUp) {
    const Pose base = base_of(20.0, -30.0);
    for (const double tilt : {-59.0, -61.0, -90.0, -120.0}) {
        const PtzPosition head{40.0, tilt, 1.0};
        const glm::dvec3 up(0, 0, 1), forward(1, 0, 0);
        const Pose plain = turned_by(base, head), flipped = turned_by(base, head, is_over(base, head));
        EXPECT_EQ(is_over(base, head), tilt < -60.0);
        EXPECT_GT((flipped.orientation * up).z, 0.0) << tilt;
        EXPECT_EQ((plain.orientation * up).z > 0.0, tilt > -60.0) << tilt;
        EXPECT_NEAR(glm::length(flipped.orientation * forward - plain.orientation * forward), 0.0, 1e-15);
    }
}

TEST(PtzAxes, WhatItIsAimedAlongIsInItsMiddleOnItsSideOfThePole) {
    std::uint64_t n = 0;
    const auto random = [&](double low, double high) { return low + (high - low) * random_unit(2, 0, n++); };
    for (int round = 0; round < 20'000; ++round) {
        const double base_tilt = random(-90.0, 90.0);
        const Pose base = base_of(random(-180.0, 180.0), base_tilt, random(-180.0, 180.0));
        const PtzPosition now{random(-180.0, 180.0), random(-120.0, 120.0), 3.0};
        const glm::dvec3 direction(random(-1.0, 1.0), random(-1.0, 1.0), random(-1.0, 1.0));
        const PtzPosition aimed = aimed_along(base, direction, now);
        const glm::dvec3 forward = turned_by(base, aimed).orientation * glm::dvec3(1, 0, 0);
        ASSERT_NEAR(glm::length(forward - glm::normalize(direction)), 0.0, 1e-9);
        const auto is_over = [&](double tilt) { return glm::cos(glm::radians(base_tilt + tilt)) < 0.0; };
        ASSERT_EQ(is_over(aimed.tilt_deg), is_over(now.tilt_deg));
        ASSERT_EQ(aimed.zoom, now.zoom);
    }
    EXPECT_EQ(aimed_along(base_of(20.0, -30.0), {0, 0, -1}, {70.0, 0.0, 1.0}).pan_deg, 70.0);
}

}  // namespace
}  // namespace camrig::camera
