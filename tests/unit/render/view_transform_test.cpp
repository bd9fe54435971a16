#include "core/render/view_transform.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/base/random.h"

namespace camrig::render {
namespace {

const camera::Intrinsics off_centre{.fx = 611.3, .fy = 587.9, .cx = 301.7, .cy = 255.2};

/// Window coordinates (pixel centre = integer + 0.5) of a world point, through the clip transform.
glm::dvec2 window_of(const ViewTransform& view, const glm::dvec3& world) {
    const glm::dvec3 p = view.optical_from_world * (world - view.eye);
    const double x = (view.x_scale * p.x + view.x_shift * p.z) / p.z;
    const double y = (view.y_scale * p.y + view.y_shift * p.z) / p.z;
    return {(x + 1.0) / 2.0 * view.size.width, (y + 1.0) / 2.0 * view.size.height};
}

TEST(ViewTransform, PixelCentresAreAtIntegerCoordinatesAsInOpenCv) {
    camera::Pose pose;
    pose.position = {10, 20, 30};
    const auto view = make_view_transform(pose, {640, 480}, off_centre, 0.05, 0.0);
    // 4 m ahead, 1 m to the left, 0.5 m up: u = fx X/Z + cx with X = -1, Y = -0.5.
    const glm::dvec2 window = window_of(view, {14, 21, 30.5});
    EXPECT_NEAR(window.x, 611.3 * -0.25 + 301.7 + 0.5, 1e-9);
    EXPECT_NEAR(window.y, 587.9 * -0.125 + 255.2 + 0.5, 1e-9);
}

TEST(ViewTransform, DepthIsOneAtTheNearPlaneAndComesBackAsMetres) {
    for (const double far_m : {0.0, 500.0}) {
        const auto view = make_view_transform({}, {640, 480}, off_centre, 0.25, far_m);
        EXPECT_DOUBLE_EQ(view.depth_scale + view.depth_shift / 0.25, 1.0);
        for (const double z : {0.25, 1.0, 77.0, 499.0}) {
            const auto depth = static_cast<float>(view.depth_scale + view.depth_shift / z);
            EXPECT_NEAR(metres_of_depth(view, depth) / z, 1.0, far_m > 0 ? 1e-4 : 2e-7);
        }
        EXPECT_TRUE(std::isinf(metres_of_depth(view, 0.0f)));
    }
}

TEST(Frustum, ABoxWithAPointInThePictureIsNeverCulled) {
    camera::Pose pose;
    pose.position = {-3, 5, 1};
    pose.orientation = glm::angleAxis(0.7, glm::normalize(glm::dvec3(1, 2, 3)));
    const auto view = make_view_transform(pose, {640, 480}, off_centre, 0.05, 0.0);
    const Frustum frustum = make_frustum(view, 0.0);
    std::uint64_t drawn = 0;
    const auto uniform = [&](double low, double high) { return low + (high - low) * random_unit(7, 0, drawn++); };
    int seen = 0;
    for (int i = 0; i < 20'000; ++i) {
        glm::dmat4 world_from_local(glm::mat3_cast(glm::angleAxis(
            uniform(0, 6), glm::normalize(glm::dvec3(uniform(-1, 1), uniform(-1, 1), uniform(0.1, 1))))));
        world_from_local[3] = glm::dvec4(uniform(-20, 20), uniform(-20, 20), uniform(-20, 20), 1.0);
        const glm::vec3 half(uniform(0, 3), uniform(0, 3), uniform(0, 3));
        const glm::dvec3 inside(uniform(-half.x, half.x), uniform(-half.y, half.y), uniform(-half.z, half.z));
        const glm::dvec3 world(world_from_local * glm::dvec4(inside, 1.0));
        const glm::dvec3 optical = view.optical_from_world * (world - view.eye);
        const glm::dvec2 window = window_of(view, world);
        if (optical.z < 0.05 || window.x < 0 || window.x > 640 || window.y < 0 || window.y > 480) continue;
        ++seen;
        ASSERT_TRUE(may_be_visible(frustum, view.optical_from(world_from_local), -half, half));
    }
    EXPECT_GT(seen, 500);
}

TEST(Frustum, BoxesBehindBesideAndBeyondAreCulled) {
    const auto view = make_view_transform({}, {640, 480}, off_centre, 0.05, 100.0);
    const Frustum frustum = make_frustum(view, 100.0);
    for (const glm::dvec3 place :
         {glm::dvec3(-5, 0, 0), {5, 20, 0}, {5, -20, 0}, {5, 0, 20}, {5, 0, -20}, {105, 0, 0}}) {
        glm::dmat4 world_from_local(1.0);
        world_from_local[3] = glm::dvec4(place, 1.0);
        EXPECT_FALSE(may_be_visible(frustum, view.optical_from(world_from_local), glm::vec3(-1), glm::vec3(1)));
    }
}

}  // namespace
}  // namespace camrig::render
