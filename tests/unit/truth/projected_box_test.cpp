#include "core/truth/projected_box.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <gtest/gtest.h>

#include "tests/unit/camera/random_lens.h"

namespace camrig::truth {
namespace {

constexpr double near_m = 0.05;

camera::CameraModel camera_with(const camera::Lens& lens, double focal_px = 300.0) {
    return camera::CameraModel::create({640, 480}, {focal_px, focal_px, 319.5, 239.5}, lens).value();
}

world::Primitive triangle_primitive() {
    world::Primitive p;
    p.indices = {0, 1, 2};
    return p;
}

/// The box of a triangle by brute force: many points of its area and more of its edges. Always a little too small.
ProjectedBox sampled(const camera::CameraModel& camera, const std::vector<glm::dvec3>& corners, double far_m = 0.0) {
    const bool has_planes = camera.lens().lens().model != camera::LensModel::equidistant;
    constexpr int steps = 500;
    constexpr int edge_steps = 20000;
    ProjectedBox box;
    const auto visit = [&](double a, double b) {
        const glm::dvec3 p = corners[0] * (1 - a - b) + corners[1] * a + corners[2] * b;
        if (has_planes && (p.z < near_m || (far_m > 0 && p.z > far_m))) return;
        if (const auto pixel = camera.project(p)) box.grow(*pixel);
    };
    for (int i = 0; i <= steps; ++i) {
        for (int j = 0; i + j <= steps; ++j) visit(double(i) / steps, double(j) / steps);
    }
    for (int i = 0; i <= edge_steps; ++i) {
        const double t = double(i) / edge_steps;
        visit(t, 0.0);
        visit(0.0, t);
        visit(t, 1.0 - t);
    }
    return box;
}

ProjectedBox projected(const camera::CameraModel& camera, const std::vector<glm::dvec3>& corners, double far_m = 0.0) {
    ProjectedBox box;
    EXPECT_TRUE(BoxProjector(camera, near_m, far_m).add(corners, triangle_primitive(), box));
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
        // Never inside of what a sample shows, but for the tolerance.
        EXPECT_LE(min, brute_min + 2e-4);
        EXPECT_GE(max, brute_max - 2e-4);
        EXPECT_NEAR(min, brute_min, tolerance_px);
        EXPECT_NEAR(max, brute_max, tolerance_px);
    }
}

TEST(ProjectedBox, IsTheCornersForAPinhole) {
    const camera::CameraModel camera = camera_with({});
    const auto box = projected(camera, {{-1, -1, 4}, {1, -1, 4}, {0, 2, 5}});
    EXPECT_FALSE(box.is_clipped);
    EXPECT_DOUBLE_EQ(box.min.x, 319.5 - 75.0);
    EXPECT_DOUBLE_EQ(box.max.x, 319.5 + 75.0);
    EXPECT_DOUBLE_EQ(box.min.y, 239.5 - 75.0);
    EXPECT_DOUBLE_EQ(box.max.y, 239.5 + 120.0);
}

TEST(ProjectedBox, EndsAtTheNearPlane) {
    const camera::CameraModel camera = camera_with({});
    // A floor from behind the camera to 10 m ahead: its lower end is where the near plane cuts it.
    const auto box = projected(camera, {{-1, 1, -10}, {1, 1, -10}, {0, 1, 10}});
    EXPECT_TRUE(box.is_clipped);
    EXPECT_DOUBLE_EQ(box.min.y, 239.5 + 30.0);
    EXPECT_NEAR(box.max.y, 239.5 + 300.0 / near_m, 1e-6);
}

TEST(ProjectedBox, EndsAtTheFarPlane) {
    const camera::CameraModel camera = camera_with({});
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
    const camera::CameraModel camera = camera_with({camera::LensModel::plumb_bob, {-0.25, 0.05}});
    const std::vector<glm::dvec3> corners{{1, -1.4, 2}, {1, 1.4, 2}, {0.9, 0, 2}};
    const auto box = projected(camera, corners);
    EXPECT_GT(box.max.x, std::max(camera.project(corners[0])->x, camera.project(corners[1])->x) + 5.0);
    expect_same(box, sampled(camera, corners), 0.2);
}

TEST(ProjectedBox, MatchesBruteForceThroughManyLensesAndPlaces) {
    int compared = 0;
    for (std::uint64_t n = 0; n < 90; ++n) {
        const camera::Lens lens = camera::random_lens(n);
        const auto camera = camera::CameraModel::create({640, 480}, {300, 300, 319.5, 239.5}, lens);
        if (!camera) continue;
        camera::Draw draw(5000 + n);
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

/// The box of the edges alone, densely sampled; at most 1e-4 px too small for what these tests look at.
ProjectedBox sampled_edges(const camera::CameraModel& camera, const std::vector<glm::dvec3>& corners) {
    constexpr int steps = 20000;
    ProjectedBox box;
    for (std::size_t e = 0; e < 3; ++e) {
        for (int i = 0; i <= steps; ++i)
            box.grow(camera.project(glm::mix(corners[e], corners[(e + 1) % 3], double(i) / steps)).value());
    }
    return box;
}

TEST(ProjectedBox, IsWithinAThousandthOfAPixelOfFinelySampledEdgesThroughManyLenses) {
    int compared = 0;
    for (std::uint64_t n = 0; n < 120; ++n) {
        const auto camera = camera::CameraModel::create({640, 480}, {300, 300, 319.5, 239.5}, camera::random_lens(n));
        if (!camera) continue;
        camera::Draw draw(7000 + n);
        std::vector<glm::dvec3> corners;
        for (int c = 0; c < 3; ++c)
            corners.emplace_back(draw.uniform(-0.7, 0.7), draw.uniform(-0.7, 0.7), draw.uniform(1.5, 2.5));
        const auto box = projected(*camera, corners);
        if (box.is_clipped) continue;
        const auto brute = sampled_edges(*camera, corners);
        SCOPED_TRACE(testing::Message() << "lens " << n);
        for (int axis = 0; axis < 2; ++axis) {
            EXPECT_NEAR(box.min[axis], brute.min[axis], 1e-3);
            EXPECT_NEAR(box.max[axis], brute.max[axis], 1e-3);
        }
        ++compared;
    }
    EXPECT_GT(compared, 60);
}

/// A room of 20 x 4 x 30 m with 128 triangles a side, its middle at `middle` of the optical frame.
struct Room {
    std::vector<glm::dvec3> points;
    world::Primitive primitive;
    explicit Room(const glm::dvec3& middle) {
        constexpr int cells = 8;
        for (int axis = 0; axis < 3; ++axis) {
            for (const double side : {-1.0, 1.0}) {
                const auto first = static_cast<std::uint32_t>(points.size());
                for (int i = 0; i <= cells; ++i) {
                    for (int j = 0; j <= cells; ++j) {
                        glm::dvec3 p;
                        p[axis] = side;
                        p[(axis + 1) % 3] = 2.0 * i / cells - 1.0;
                        p[(axis + 2) % 3] = 2.0 * j / cells - 1.0;
                        points.push_back(middle + p * glm::dvec3(10.0, 2.0, 15.0));
                    }
                }
                for (std::uint32_t i = 0; i < cells; ++i) {
                    for (std::uint32_t j = 0; j < cells; ++j) {
                        const std::uint32_t at = first + i * (cells + 1) + j;
                        for (const std::uint32_t k : {0, 1, cells + 1, 1, cells + 2, cells + 1})
                            primitive.indices.push_back(at + k);
                    }
                }
            }
        }
    }
};

// Each of these once took from seconds to minutes: far beside the axis a lens magnifies without bound, and an edge
// there is 1e30 pixels long.
TEST(ProjectedBox, LensesThatMagnifyWithoutBoundTakeBoundedWork) {
    struct Case {
        const char* name;
        camera::Lens lens;
        double focal_px;
    };
    const std::vector<Case> cases{
        {"plumb_bob", {camera::LensModel::plumb_bob, {-0.3, 0.1}}, 55.4},
        {"pincushion", {camera::LensModel::plumb_bob, {0.4, 0.3, 0.001, -0.002, 0.1}}, 55.4},
        {"rational", {camera::LensModel::rational_polynomial, {8.0, 4.0, 0.001, 0.0, 0.5, 8.3, 6.0, 1.5}}, 55.4},
        {"equidistant", {camera::LensModel::equidistant, {}}, 55.4},
        {"equidistant, long", {camera::LensModel::equidistant, {}}, 1e6},
        {"equidistant, folding", {camera::LensModel::equidistant, {0.05, -0.1}}, 55.4},
    };
    for (const Case& c : cases) {
        const auto camera = camera::CameraModel::create({64, 48}, {c.focal_px, c.focal_px, 31.5, 23.5}, c.lens);
        ASSERT_TRUE(camera) << c.name;
        for (const double beside : {0.0, 2.0, 50.0, 1e3, 1e4, 1e5}) {
            for (const double ahead : {0.0, 14.9, 20.0}) {
                const Room room({beside, 0.3, ahead});
                BoxProjector projector(*camera, near_m, 0.0);
                ProjectedBox box;
                const auto added = projector.add(room.points, room.primitive, box);
                EXPECT_TRUE(added) << c.name << " " << beside << " " << ahead << ": " << added.error().message;
                EXPECT_LT(projector.halvings(), 20'000) << c.name << " " << beside << " " << ahead;
            }
        }
    }
}

TEST(ProjectedBox, AWallAllAroundAFisheyeFillsItsField) {
    const camera::CameraModel camera = camera_with({camera::LensModel::equidistant, {0.05, -0.1}}, 120.0);
    ASSERT_TRUE(camera.lens().folds());
    // No edge of this triangle is inside of the field: the picture ends at the rim.
    const auto box = projected(camera, {{-900, -500, 1}, {900, -500, 1}, {0, 900, 1}});
    const double rim = camera.max_field_angle() - 1e-7;
    const double radius = camera.project({std::sin(rim), 0, std::cos(rim)})->x - 319.5;
    EXPECT_TRUE(box.is_clipped);
    EXPECT_NEAR(box.min.x, 319.5 - radius, 0.1);
    EXPECT_NEAR(box.max.x, 319.5 + radius, 0.1);
    EXPECT_NEAR(box.min.y, 239.5 - radius, 0.1);
    EXPECT_NEAR(box.max.y, 239.5 + radius, 0.1);
}

TEST(ProjectedBox, AWallRightBehindAFisheyeReachesItsRimThoughAllItsCornersAreSeen) {
    const camera::CameraModel camera = camera_with({camera::LensModel::equidistant, {}}, 50.0);
    const auto box = projected(camera, {{-9, -5, -1}, {9, -5, -1}, {0, 9, -1}});
    const double radius = 50.0 * std::numbers::pi;
    EXPECT_FALSE(box.is_clipped);
    EXPECT_NEAR(box.min.x, 319.5 - radius, 1e-2);
    EXPECT_NEAR(box.max.x, 319.5 + radius, 1e-2);
    EXPECT_NEAR(box.min.y, 239.5 - radius, 1e-2);
    EXPECT_NEAR(box.max.y, 239.5 + radius, 1e-2);
}

TEST(ProjectedBox, LinesAndPointsHaveBoxes) {
    const camera::CameraModel camera = camera_with({});
    const std::vector<glm::dvec3> points{{0, 1, -5}, {0, 1, 5}, {1, 0, 3}};
    BoxProjector projector(camera, near_m, 0.0);
    world::Primitive line;
    line.topology = world::Topology::lines;
    line.indices = {0, 1};
    ProjectedBox box;
    ASSERT_TRUE(projector.add(points, line, box));
    EXPECT_NEAR(box.max.y, 239.5 + 300.0 / near_m, 1e-6);
    EXPECT_NEAR(box.min.y, 239.5 + 60.0, 1e-9);
    world::Primitive dots;
    dots.topology = world::Topology::points;
    dots.indices = {2};
    ProjectedBox dot;
    ASSERT_TRUE(projector.add(points, dots, dot));
    EXPECT_EQ(dot.min, dot.max);
    EXPECT_DOUBLE_EQ(dot.min.x, 319.5 + 100.0);
}

}  // namespace
}  // namespace camrig::truth
