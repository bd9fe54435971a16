#include "tools/view/sight.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

constexpr double vfov = std::numbers::pi / 3;

/// From (1, 2, 3), a bit down and to the side, into a rectangle that is not at the window's corner.
Sight tilted() {
    const auto pose = camera::pose_from_angles({1, 2, 3}, {.pan = 0.6, .tilt = -0.4, .roll = 0}).value();
    return {pose, vfov, {260, 10}, {720, 630}};
}

TEST(Sight, TheMiddleIsStraightAheadAndTheUpperEdgeHalfTheFieldOfView) {
    const auto pose = camera::pose_from_angles({0, 0, 0}, {}).value();  // along +x
    const Sight sight(pose, vfov, {100, 50}, {400, 300});
    const auto middle = sight.project({10, 0, 0});
    ASSERT_TRUE(middle);
    EXPECT_NEAR(glm::length(*middle - glm::dvec2(300, 200)), 0, 1e-9);
    const auto top = sight.project({10, 0, 10 * std::tan(vfov / 2)});
    EXPECT_NEAR(top->y, 50, 1e-9);
    const auto left = sight.project({10, 1, 0});  // +y is left
    EXPECT_LT(left->x, 300);
}

TEST(Sight, ARayGoesThroughWhatIsSeenThere) {
    const Sight sight = tilted();
    for (const glm::dvec3& point : {glm::dvec3(8, 5, 0), glm::dvec3(4, 6, 2), glm::dvec3(20, 11, 7)}) {
        const auto seen = sight.project(point);
        ASSERT_TRUE(seen);
        const Ray ray = sight.ray(*seen);
        EXPECT_NEAR(glm::length(glm::cross(ray.direction, glm::normalize(point - ray.origin))), 0, 1e-12);
        EXPECT_NEAR(glm::length(ray.direction), 1, 1e-12);
    }
}

TEST(Sight, WhatIsBehindIsNotSeenAndALineIsCutThere) {
    const Sight sight = tilted();
    const glm::dvec3 ahead = sight.ray({620, 325}).direction;
    const glm::dvec3 before = sight.position() + 2.0 * ahead, behind = sight.position() - 5.0 * ahead;
    EXPECT_FALSE(sight.project(behind));
    EXPECT_FALSE(sight.project(behind, behind + glm::dvec3(0, 0, 0.1)));
    const glm::dvec3 aside = behind + 0.01 * glm::normalize(glm::cross(ahead, glm::dvec3(0, 0, 1)));
    const auto line = sight.project(before, aside);
    ASSERT_TRUE(line);
    EXPECT_NEAR(glm::length(line->first - *sight.project(before)), 0, 1e-9);
    EXPECT_TRUE(std::isfinite(line->second.x) && std::isfinite(line->second.y));
    // Both ways round the same piece is left.
    const auto other = sight.project(aside, before);
    EXPECT_NEAR(glm::length(other->first - line->second), 0, 1e-9);
}

TEST(MeetPlane, IsWhereTheRayComesDownAndNowhereAboveTheHorizon) {
    const Sight sight = tilted();
    const glm::dvec3 point(9, 7, 0.5);
    const auto met = meet_plane(sight.ray(*sight.project(point)), 0.5);
    ASSERT_TRUE(met);
    EXPECT_NEAR(glm::length(*met - point), 0, 1e-9);
    EXPECT_FALSE(meet_plane({{0, 0, 1}, {1, 0, 0}}, 0));
    EXPECT_FALSE(meet_plane({{0, 0, 1}, glm::normalize(glm::dvec3(1, 0, 0.1))}, 0));
    EXPECT_TRUE(meet_plane({{0, 0, 1}, glm::normalize(glm::dvec3(1, 0, 0.1))}, 2));
}

TEST(HeightBeside, IsTheHeightAtWhichTheRayPassesAPlace) {
    const Sight sight = tilted();
    for (const double height : {0.0, 1.5, 3.0, 4.5}) {
        const auto seen = sight.project({7, 6, height});
        ASSERT_TRUE(seen);
        EXPECT_NEAR(height_beside(sight.ray(*seen), {7, 6, 1}), height, 1e-9);
    }
    EXPECT_EQ(height_beside({{0, 0, 5}, {0, 0, -1}}, {1, 1, 2}), 2);
}

TEST(MeetSphere, KeepsItsDistanceAndTakesTheNearerOfTwoPoints) {
    const Ray ray{{0, 0, 0}, {1, 0, 0}};
    const glm::dvec3 centre(10, 0, 0);
    EXPECT_NEAR(glm::length(meet_sphere(ray, centre, 2, {8.5, 0, 1}) - glm::dvec3(8, 0, 0)), 0, 1e-12);
    EXPECT_NEAR(glm::length(meet_sphere(ray, centre, 2, {11.5, 0, 1}) - glm::dvec3(12, 0, 0)), 0, 1e-12);
    // The eye is inside: only what is before it.
    EXPECT_NEAR(glm::length(meet_sphere({{9, 0, 0}, {1, 0, 0}}, centre, 2, {8, 0, 0}) - glm::dvec3(12, 0, 0)), 0,
                1e-12);
    // Past it: the direction to where the ray is nearest.
    EXPECT_NEAR(glm::length(meet_sphere(ray, {10, 0, 5}, 2, {10, 0, 7}) - glm::dvec3(10, 0, 3)), 0, 1e-12);
}

}  // namespace
}  // namespace camrig::view
