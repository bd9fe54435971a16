#pragma once

#include "core/camera/camera_model.h"
#include "core/render/renderer_factory.h"
#include "tests/render/support/test_models.h"

namespace camrig::render {

/// A camera for tests: at `eye`, looking along world +x with z up (image right is -y, image down is -z).
struct TestCamera {
    glm::dvec3 eye{0.0};
    ImageSize size{64, 48};
    double focal_px = 64.0;                                       ///< fx = fy
    std::optional<camera::Intrinsics> intrinsics = std::nullopt;  ///< instead of a centred focal_px
    camera::Lens lens{};
    world::LensSampling lens_sampling{};
    world::Antialias antialias = world::Antialias::none;
    double near_m = 0.05;
    double far_m = 0.0;
    world::Quality quality = world::Quality::simple;

    View view(std::uint32_t number = 1) const;
    camera::CameraModel model() const;
};

/// Pixels of a colour frame with 2D access.
struct Picture {
    frame::FrameRef frame;
    std::array<int, 4> at(int x, int y) const;
    int red(int x, int y) const { return at(x, y)[0]; }
};

/// The renderer of the device that CAMRIG_TEST_DEVICE names, "cpu" if it names none; one per test program (contexts are
/// slow to make).
Renderer& cpu_renderer();

Picture draw(const TestWorld& world, const TestCamera& camera);
frame::FrameRef draw_kind(const TestWorld& world, const TestCamera& camera, frame::FrameKind kind);
/// Draws a view as it is; fails the test if anything is missing.
std::vector<frame::FrameRef> draw_views(const world::SnapshotRef& snapshot, std::span<const View> views);

/// The exact sRGB code of a linear value, in double.
int srgb_code(double linear);
/// And back.
double linear_of(int code);

}  // namespace camrig::render
