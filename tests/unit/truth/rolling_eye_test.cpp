#include "core/truth/rolling_eye.h"

#include <cmath>

#include <gtest/gtest.h>

#include "core/world/world.h"

namespace camrig::truth {
namespace {

constexpr TimeNs now_ns = 100 * ns_per_ms;

struct Zooming {
    world::CameraSpec spec;  ///< as it is when its last row is read
    RowsInTime rows;
};

/// A camera before which nothing moves, at the origin; its focal length is 1.8 times as long after a tenth of a second.
Zooming zooming(const camera::Lens& lens) {
    world::CameraPatch place;
    place.size = ImageSize{64, 48};
    place.optics = camera::Intrinsics{40.0, 40.0, 31.5, 23.5};
    place.lens = lens;
    world::CameraPatch zoom;
    zoom.zoom = 1.8;
    const world::Camera camera =
        world::Camera(world::patch_camera_spec({}, place).value()).changed(zoom, 0, now_ns).value();
    const auto world = world::World::create(std::make_shared<world::Scene>(), 1).value();
    world->advance_to(now_ns);
    return {.spec = camera.spec_at(now_ns),
            .rows = {.past = std::make_shared<const world::CameraPast>(world->past(0), camera),
                     .first_ns = now_ns - 47 * ns_per_ms,
                     .row_ns = ns_per_ms}};
}

const glm::dvec3 points[] = {{5.0, 2.0, 1.0}, {5.0, -1.5, -1.2}, {8.0, 0.5, 0.0}};

glm::dvec3 optical(const glm::dvec3& point) {
    return glm::transpose(camera::world_from_optical_rotation({})) * point;
}

TEST(RollingEye, OfAPinholeThatZoomsHasTheFocalLengthOfEachRow) {
    const auto [spec, rows] = zooming({});
    const auto camera = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens).value();
    const RollingEye eye(rows, camera);
    for (const glm::dvec3& point : points) {
        const glm::dvec2 pixel = camera.project(eye.see(point, point)).value();
        const auto row_ns = rows.first_ns + std::llround(pixel.y * static_cast<double>(rows.row_ns));
        const double focal_px = rows.past->at(row_ns).state.intrinsics.fx;
        EXPECT_LT(focal_px, spec.intrinsics.fx);
        EXPECT_NEAR(pixel.x, 31.5 - focal_px * point.y / point.x, 0.01);
        EXPECT_NEAR(pixel.y, 23.5 - focal_px * point.z / point.x, 0.01);
    }
}

// Its pictures have the focal length of their instant in all rows.
TEST(RollingEye, ThroughALensThatZoomsHasTheFocalLengthOfTheInstant) {
    for (const camera::Lens& lens : {camera::Lens{camera::LensModel::plumb_bob, {-0.2, 0.03, 0.001, 0.0, 0.0}},
                                     camera::Lens{camera::LensModel::equidistant, {-0.01, 0.002, 0.0, 0.0}}}) {
        const auto [spec, rows] = zooming(lens);
        const auto camera = camera::CameraModel::create(spec.size, spec.intrinsics, spec.lens).value();
        EXPECT_LT(rows.past->at(rows.first_ns).state.intrinsics.fx, 0.9 * spec.intrinsics.fx);
        const RollingEye eye(rows, camera);
        for (const glm::dvec3& point : points) EXPECT_LT(glm::distance(eye.see(point, point), optical(point)), 1e-12);
    }
}

}  // namespace
}  // namespace camrig::truth
