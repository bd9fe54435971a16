#include "tools/view/camera_drag.h"

#include <array>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

Sight sight() {
    const auto pose = camera::pose_from_angles({0, 0, 4}, {.pan = 0, .tilt = -0.4, .roll = 0}).value();
    return {pose, 1, {0, 0}, {800, 600}};
}

camera::Pose start() {
    return camera::pose_from_angles({8, 1, 2}, {.pan = 0.5, .tilt = -0.2, .roll = 0.3}).value();
}

TEST(CameraDrag, ABodyFollowsTheMouseAtItsHeightAndKeepsItsDirection) {
    const glm::dvec2 hold = *sight().project(start().position) + glm::dvec2(3, -2);  // not quite hit
    CameraDrag drag("lobby", Grip::body, start(), sight().ray(hold), 1);
    const camera::Pose there = drag.to(sight().ray(hold + glm::dvec2(60, 40)));
    EXPECT_NEAR(there.position.z, 2, 1e-12);
    EXPECT_EQ(there.orientation, start().orientation);
    // What was held is under the mouse; the camera itself as far beside it as at the start, seen from a bit nearer.
    EXPECT_NEAR(glm::length(*sight().project(there.position) + glm::dvec2(3, -2) - hold - glm::dvec2(60, 40)), 0, 2);
    // And back.
    EXPECT_NEAR(glm::length(drag.to(sight().ray(hold)).position - start().position), 0, 1e-9);
}

TEST(CameraDrag, ABodyStaysWhereItWasWhileTheMouseIsAboveTheHorizon) {
    CameraDrag drag("lobby", Grip::body, start(), sight().ray(*sight().project(start().position)), 1);
    const camera::Pose before = drag.to(sight().ray(*sight().project({9, 2, 2})));
    EXPECT_EQ(drag.to(sight().ray({400, 5})).position, before.position);
}

TEST(CameraDrag, ALiftGoesUpAndDownOnly) {
    CameraDrag drag("lobby", Grip::lift, start(), sight().ray(*sight().project(start().position)), 1);
    const camera::Pose there = drag.to(sight().ray(*sight().project({8, 1, 3.25}) + glm::dvec2(0, 0)));
    EXPECT_NEAR(glm::length(there.position - glm::dvec3(8, 1, 3.25)), 0, 1e-9);
    EXPECT_EQ(there.orientation, start().orientation);
}

TEST(CameraDrag, AHandleTurnsTheCameraToTheMouseAndKeepsPlaceAndRoll) {
    const glm::dvec3 handle = start().position + glm::mat3_cast(start().orientation) * glm::dvec3(1, 0, 0);
    CameraDrag drag("lobby", Grip::handle, start(), sight().ray(*sight().project(handle)), 1);
    const auto goal = camera::pose_from_angles(start().position, {.pan = 0.9, .tilt = 0.1, .roll = 0.3}).value();
    const glm::dvec3 there = goal.position + glm::mat3_cast(goal.orientation) * glm::dvec3(1, 0, 0);
    const camera::Pose turned = drag.to(sight().ray(*sight().project(there)));
    EXPECT_EQ(turned.position, start().position);
    const camera::PanTiltRoll angles = camera::angles_of(turned.orientation);
    EXPECT_NEAR(angles.pan, 0.9, 1e-9);
    EXPECT_NEAR(angles.tilt, 0.1, 1e-9);
    EXPECT_NEAR(angles.roll, 0.3, 1e-9);
}

TEST(NearestGrip, IsTheOneUnderTheMouseOrNone) {
    const std::array<GripPoint, 3> grips{
        {{"a", Grip::body, {10, 10}}, {"b", Grip::body, {18, 10}}, {"b", Grip::handle, {60, 10}}}};
    EXPECT_EQ(nearest_grip(grips, {13, 10})->camera, "a");
    EXPECT_EQ(nearest_grip(grips, {15, 10})->camera, "b");
    EXPECT_EQ(nearest_grip(grips, {58, 12})->grip, Grip::handle);
    EXPECT_EQ(nearest_grip(grips, {40, 10}), nullptr);
    // Seen from behind: body and handle in one place.
    const std::array<GripPoint, 2> behind{{{"c", Grip::body, {30, 30.5}}, {"c", Grip::handle, {30, 30}}}};
    EXPECT_EQ(nearest_grip(behind, {30, 30})->grip, Grip::body);
}

}  // namespace
}  // namespace camrig::view
