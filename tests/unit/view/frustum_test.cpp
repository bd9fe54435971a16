#include "tools/view/frustum.h"

#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

namespace camrig::view {
namespace {

client::CameraState pinhole() {
    client::CameraState camera;
    camera.size = {640, 480};
    camera.intrinsics = {400, 400, 319.5, 239.5};
    return camera;
}

TEST(Frustum, OfAPinholeEndsInTheRectangleOfItsPicture) {
    const auto pose = camera::pose_from_angles({1, 2, 3}, {}).value();  // along +x, left is +y
    const Frustum frustum = frustum_of(pinhole(), pose, 2);
    EXPECT_EQ(frustum.apex, pose.position);
    EXPECT_NEAR(glm::length(frustum.handle - glm::dvec3(3, 2, 3)), 0, 1e-12);
    const glm::dvec3 half(0, 2 * 320.0 / 400, 2 * 240.0 / 400);
    const std::array<glm::dvec3, 4> expected{
        glm::dvec3(3, 2 + half.y, 3 + half.z), glm::dvec3(3, 2 - half.y, 3 + half.z),
        glm::dvec3(3, 2 - half.y, 3 - half.z), glm::dvec3(3, 2 + half.y, 3 - half.z)};
    for (std::size_t i = 0; i < 4; ++i) {
        ASSERT_TRUE(frustum.corners[i]);
        EXPECT_NEAR(glm::length(*frustum.corners[i] - expected[i]), 0, 1e-9) << i;
    }
    EXPECT_EQ(frustum.lines.size(), 4u + 4 * 8);
}

TEST(Frustum, TurnsWithItsCamera) {
    const auto pose = camera::pose_from_angles({0, 0, 0}, {.pan = std::numbers::pi / 2, .tilt = 0, .roll = 0}).value();
    EXPECT_NEAR(glm::length(frustum_of(pinhole(), pose, 1).handle - glm::dvec3(0, 1, 0)), 0, 1e-12);
}

TEST(Frustum, FollowsALensWhoseEdgesAreBent) {
    client::CameraState camera = pinhole();
    camera.lens.model = "plumb_bob";
    camera.lens.coefficients = {-0.08, 0, 0, 0, 0};
    const Frustum frustum = frustum_of(camera, camera::pose_from_angles({0, 0, 0}, {}).value(), 1);
    ASSERT_TRUE(frustum.corners[0] && frustum.corners[1]);
    // Barrel distortion: the corners see farther out than the middle of the edge between them.
    const glm::dvec3 middle_of_edge = frustum.lines[4].second;
    EXPECT_GT(frustum.corners[0]->z, middle_of_edge.z + 0.01);
}

TEST(Frustum, OfAFisheyeStaysNear) {
    client::CameraState camera = pinhole();
    camera.lens.model = "equidistant";
    camera.lens.coefficients = {0, 0, 0, 0};
    camera.intrinsics = {200, 200, 319.5, 239.5};  // 183 degrees across
    const Frustum frustum = frustum_of(camera, camera::pose_from_angles({0, 0, 0}, {}).value(), 1);
    EXPECT_FALSE(frustum.lines.empty());
    for (const auto& [from, to] : frustum.lines) EXPECT_LE(glm::length(to), 2.0 + 1e-9);
}

TEST(Frustum, OfALensThatThisProgramDoesNotKnowIsItsPlaceAndDirection) {
    client::CameraState camera = pinhole();
    camera.lens.model = "of the future";
    const Frustum frustum = frustum_of(camera, camera::pose_from_angles({0, 0, 0}, {}).value(), 1);
    EXPECT_TRUE(frustum.lines.empty());
    EXPECT_NEAR(frustum.handle.x, 1, 1e-12);
}

}  // namespace
}  // namespace camrig::view
