#include "core/truth/projected_box.h"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "tests/unit/camera/random_lens.h"

namespace camrig {
namespace {

constexpr double near_m = 0.05;

CameraModel camera_with(const Lens& lens, double focal_px = 300.0) {
    return CameraModel::create({640, 480}, {focal_px, focal_px, 319.5, 239.5}, lens).value();
}

Primitive triangle_primitive() {
    Primitive p;
    p.indices = {0, 1, 2};
    return p;
}

/// The box of a triangle by brute force: many points of its area. Always a little too small.
ProjectedBox sampled(const CameraModel& camera, const std::vector<glm::dvec3>& corners, double far_m = 0.0) {
    const bool has_planes = camera.lens().lens().model != LensModel::equidistant;
    constexpr int steps = 1500;
    ProjectedBox box;
    for (int i = 0; i <= steps; ++i) {
        for (int j = 0; i + j <= steps; ++j) {
            const double a = double(i) / steps, b = double(j) / steps;
            const glm::dvec3 p = corners[0] * (1 - a - b) + corners[1] * a + corners[2] * b;
            if (has_planes && (p.z < near_m || (far_m > 0 && p.z > far_m))) continue;
            if (const auto pixel = camera.project(p)) box.grow(*pixel);
        }
    }
    return box;
}

ProjectedBox projected(const CameraModel& camera, const std::vector<glm::dvec3>& corners, double far_m = 0.0) {
    ProjectedBox box;
    BoxProjector(camera, near_m, far_m).add(corners, triangle_primitive(), box);
    return box;
}

void expect_same(const ProjectedBox& box, const ProjectedBox& brute, double tolerance_px) {
    ASSERT_EQ(box.is_empty(), brute.is_empty());
    if (brute.is_empty()) return;
    // Far beside the picture a lens magnifies without bound: there samples lie many pixels apart.
    const auto near_picture = [](double pixel) { return std::clamp(pixel, -1000.0, 1600.0); };
    for (int axis = 0; axis < 2; ++axis) {
        const double min = near_picture(box.min[axis]), brute_min = near_picture(brute.min[axis]);
        const double max = near_picture(box.max[axis]), brute_max = near_picture(brute.max[axis]);
        // Never inside of what a sample shows but for the bulge between two followed points.
        EXPECT_LE(min, brute_min + 0.25);
        EXPECT_GE(max, brute_max - 0.25);
        EXPECT_NEAR(min, brute_min, tolerance_px);
        EXPECT_NEAR(max, brute_max, tolerance_px);
    }
}

TEST(ProjectedBox, IsTheCornersForAPinhole) {
    const CameraModel camera = camera_with({});
    const auto box = projected(camera, {{-1, -1, 4}, {1, -1, 4}, {0, 2, 5}});
    EXPECT_FALSE(box.is_clipped);
    EXPECT_DOUBLE_EQ(box.min.x, 319.5 - 75.0);
    EXPECT_DOUBLE_EQ(box.max.x, 319.5 + 75.0);
    EXPECT_DOUBLE_EQ(box.min.y, 239.5 - 75.0);
    EXPECT_DOUBLE_EQ(box.max.y, 239.5 + 120.0);
}

TEST(ProjectedBox, EndsAtTheNearPlane) {
    const CameraModel camera = camera_with({});
    // A floor from behind the camera to 10 m ahead: its lower end is where the near plane cuts it.
    const auto box = projected(camera, {{-1, 1, -10}, {1, 1, -10}, {0, 1, 10}});
    EXPECT_TRUE(box.is_clipped);
    EXPECT_DOUBLE_EQ(box.min.y, 239.5 + 30.0);
    EXPECT_NEAR(box.max.y, 239.5 + 300.0 / near_m, 1e-6);
}

TEST(ProjectedBox, EndsAtTheFarPlane) {
    const CameraModel camera = camera_with({});
    const auto box = projected(camera, {{-1, 1, 2}, {1, 1, 2}, {0, 1, 10}}, 5.0);
    EXPECT_TRUE(box.is_clipped);
    EXPECT_NEAR(box.min.y, 239.5 + 60.0, 1e-9);
}

TEST(ProjectedBox, NothingInFrontIsEmpty) {
    const auto box = projected(camera_with({}), {{-1, 1, -3}, {1, 1, -3}, {0, 1, -1}});
    EXPECT_TRUE(box.is_empty());
    EXPECT_TRUE(box.is_clipped);
}

TEST(ProjectedBox, FollowsBentEdgesOutsideOfTheCorners) {
    // Barrel: the middle of a line beside the axis bulges outwards.
    const CameraModel camera = camera_with({LensModel::plumb_bob, {-0.25, 0.05}});
    const std::vector<glm::dvec3> corners{{1, -1.4, 2}, {1, 1.4, 2}, {0.9, 0, 2}};
    const auto box = projected(camera, corners);
    EXPECT_GT(box.max.x, std::max(camera.project(corners[0])->x, camera.project(corners[1])->x) + 5.0);
    expect_same(box, sampled(camera, corners), 0.2);
}

TEST(ProjectedBox, MatchesBruteForceThroughManyLensesAndPlaces) {
    int compared = 0;
    for (std::uint64_t n = 0; n < 90; ++n) {
        const Lens lens = random_lens(n);
        const auto camera = CameraModel::create({640, 480}, {300, 300, 319.5, 239.5}, lens);
        if (!camera) continue;
        Draw draw(5000 + n);
        for (int i = 0; i < 3; ++i) {
            const glm::dvec3 middle(draw.uniform(-2, 2), draw.uniform(-2, 2), draw.uniform(1.5, 5));
            std::vector<glm::dvec3> corners;
            for (int c = 0; c < 3; ++c)
                corners.push_back(middle + glm::dvec3(draw.uniform(-1, 1), draw.uniform(-1, 1), draw.uniform(-1, 1)));
            const auto box = projected(*camera, corners);
            const auto brute = sampled(*camera, corners);
            SCOPED_TRACE(testing::Message() << "lens " << n << " triangle " << i << " clipped " << box.is_clipped);
            if (brute.is_empty()) continue;
            // Samples miss an extreme by up to their spacing where the lens magnifies its edge.
            expect_same(box, brute, box.is_clipped ? 4.0 : 1.0);
            ++compared;
        }
    }
    EXPECT_GT(compared, 150);
}

TEST(ProjectedBox, AWallAllAroundAFisheyeFillsItsField) {
    const CameraModel camera = camera_with({LensModel::equidistant, {0.05, -0.1}}, 120.0);
    ASSERT_TRUE(camera.fold_angle());
    // No edge of this triangle is inside of the field: the picture ends at the rim.
    const auto box = projected(camera, {{-900, -500, 1}, {900, -500, 1}, {0, 900, 1}});
    const double radius =
        camera.project({std::sin(*camera.fold_angle() - 1e-7), 0, std::cos(*camera.fold_angle() - 1e-7)})->x - 319.5;
    EXPECT_TRUE(box.is_clipped);
    EXPECT_NEAR(box.min.x, 319.5 - radius, 0.1);
    EXPECT_NEAR(box.max.x, 319.5 + radius, 0.1);
    EXPECT_NEAR(box.min.y, 239.5 - radius, 0.1);
    EXPECT_NEAR(box.max.y, 239.5 + radius, 0.1);
}

TEST(ProjectedBox, LinesAndPointsHaveBoxes) {
    const CameraModel camera = camera_with({});
    const std::vector<glm::dvec3> points{{0, 1, -5}, {0, 1, 5}, {1, 0, 3}};
    const BoxProjector projector(camera, near_m, 0.0);
    Primitive line;
    line.topology = Topology::lines;
    line.indices = {0, 1};
    ProjectedBox box;
    projector.add(points, line, box);
    EXPECT_NEAR(box.max.y, 239.5 + 300.0 / near_m, 1e-6);
    EXPECT_NEAR(box.min.y, 239.5 + 60.0, 1e-9);
    Primitive dots;
    dots.topology = Topology::points;
    dots.indices = {2};
    ProjectedBox dot;
    projector.add(points, dots, dot);
    EXPECT_EQ(dot.min, dot.max);
    EXPECT_DOUBLE_EQ(dot.min.x, 319.5 + 100.0);
}

}  // namespace
}  // namespace camrig
