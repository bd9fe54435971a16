#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "core/render/software/geometry.h"
#include "tests/render/support/test_models.h"

namespace camrig::render::software {
namespace {

/// Any number from a millimetre to the greatest float, with either sign.
float any_coordinate(std::mt19937& random) {
    std::uniform_real_distribution<float> exponent(-3.0f, 38.5f), side(-1.0f, 1.0f);
    return std::copysign(std::pow(10.0f, exponent(random)), side(random));
}

world::Primitive any_surface(world::Topology topology, std::mt19937& random) {
    std::vector<glm::vec3> corners(3000);
    for (glm::vec3& corner : corners) corner = {any_coordinate(random), any_coordinate(random), any_coordinate(random)};
    world::Primitive made = triangles(std::move(corners));
    made.topology = topology;
    return made;
}

/// Small pictures and large ones, with their middle anywhere, through short lenses and long ones.
ViewTransform any_camera(std::mt19937& random) {
    const auto within = [&](double least, double most) { return std::uniform_real_distribution(least, most)(random); };
    camera::Pose pose;
    pose.orientation = glm::angleAxis(within(0.0, 2.0 * std::numbers::pi),
                                      glm::normalize(glm::dvec3(within(-1.0, 1.0), within(-1.0, 1.0), 0.5)));
    const ImageSize size{static_cast<int>(within(16, 8192)), static_cast<int>(within(16, 8192))};
    const double focal_px = std::pow(10.0, within(0.5, 4.5));
    const camera::Intrinsics intrinsics{focal_px, focal_px * within(0.8, 1.2), within(0, size.width),
                                        within(0, size.height)};
    return make_view_transform(pose, size, intrinsics, std::pow(10.0, within(-3.0, 1.0)), 0.0);
}

// What comes later counts in 32 bits, which hold what lies within the guard and no more.
TEST(ViewGeometry, KeepsTrianglesOfCoordinatesOfAnySizeWithinTheGuard) {
    constexpr std::int32_t farthest = static_cast<std::int32_t>(guard_px) * subpixels;
    std::mt19937 random(1);
    for (const auto topology : {world::Topology::triangles, world::Topology::lines, world::Topology::points}) {
        TestWorld world;
        world::Material material = colored(glm::vec3(1.0f), true);
        material.double_sided = true;
        world.objects = {instance_of(model_of(any_surface(topology, random), material))};
        const world::SnapshotRef snapshot = world.snapshot();
        scene::PlacedScene placed(std::make_shared<scene::PreparedModels>());
        placed.place(snapshot);
        const scene::PlacedSurface& surface = placed.statics().all().front();
        const SoftwareModel model = make_software_model(**surface.source, *surface.model);
        // A stroke is a pixel wide.
        const std::int32_t beside = topology == world::Topology::triangles ? 0 : subpixels;
        std::size_t triangles = 0;
        for (int i = 0; i < 100; ++i) {
            const ViewTransform camera = any_camera(random);
            ViewGeometry geometry;
            geometry.begin_view(scene::make_scene_view(placed, camera, 0.0, world::Quality::simple, 0.0), nullptr,
                                i % 2 == 0 && has_wide_lanes());
            geometry.add({.placed = &surface,
                          .is_static = true,
                          .optical_from_local = camera.optical_from(surface.world_from_local)},
                         model.primitives.front());
            for (const ScreenTriangle& triangle : geometry.triangles()) {
                ++triangles;
                for (const std::uint32_t corner : triangle.vertices) {
                    const ScreenVertex& at = geometry.vertices()[corner];
                    ASSERT_LE(std::abs(std::int64_t{at.x}), farthest + beside) << "camera " << i;
                    ASSERT_LE(std::abs(std::int64_t{at.y}), farthest + beside) << "camera " << i;
                }
            }
        }
        EXPECT_GT(triangles, 100u);
    }
}

}  // namespace
}  // namespace camrig::render::software
