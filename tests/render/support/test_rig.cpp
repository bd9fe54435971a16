#include "tests/render/support/test_rig.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <stdexcept>

#include <gtest/gtest.h>

namespace camrig::render {

View TestCamera::view(std::uint32_t number) const {
    auto spec = std::make_shared<world::CameraSpec>();
    spec->name = "camera" + std::to_string(number);
    spec->size = size;
    spec->lens = lens;
    spec->lens_sampling = lens_sampling;
    spec->antialias = antialias;
    spec->near_m = near_m;
    spec->far_m = far_m;
    spec->intrinsics =
        intrinsics.value_or(camera::Intrinsics{focal_px, focal_px, (size.width - 1) / 2.0, (size.height - 1) / 2.0});
    View view;
    view.camera = CameraId{number};
    view.name = std::make_shared<const std::string>(spec->name);
    view.spec = spec;
    static std::uint64_t revisions = 0;  // caches must not take one test's camera for another's
    view.spec_revision = ++revisions;
    view.pose.position = eye;
    view.quality = quality;
    view.camera_number = number;
    return view;
}

camera::CameraModel TestCamera::model() const {
    const View seen = view();
    return camera::CameraModel::create(size, seen.spec->intrinsics, lens).value();
}

std::array<int, 4> Picture::at(int x, int y) const {
    const auto* p = reinterpret_cast<const std::uint8_t*>(frame->bytes().data()) +
                    4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(frame->info().size.width) +
                         static_cast<std::size_t>(x));
    return {p[0], p[1], p[2], p[3]};
}

Renderer& cpu_renderer() {
    static const std::unique_ptr<Renderer> renderer = [] {
        const char* const device = std::getenv("CAMRIG_TEST_DEVICE");
        auto made = create_renderer(
            {.device = device != nullptr ? device : "cpu", .pool = std::make_shared<frame::FramePool>()});
        if (!made) throw std::runtime_error(made.error().message);
        return std::move(*made);
    }();
    return *renderer;
}

std::vector<frame::FrameRef> draw_views(const world::SnapshotRef& snapshot, std::span<const View> views) {
    auto finished = cpu_renderer().draw(snapshot, 0, views);
    EXPECT_TRUE(finished.has_value());
    for (const auto& failure : finished->failures) ADD_FAILURE() << failure.error.message;
    return finished->set.frames;
}

Picture draw(const TestWorld& world, const TestCamera& camera) {
    const View view = camera.view();
    return {draw_views(world.snapshot(), {&view, 1}).at(0)};
}

frame::FrameRef draw_kind(const TestWorld& world, const TestCamera& camera, frame::FrameKind kind) {
    View view = camera.view();
    std::ranges::fill(view.kinds, false);
    view.kinds[static_cast<int>(kind)] = true;
    return draw_views(world.snapshot(), {&view, 1}).at(0);
}

int srgb_code(double linear) {
    const double c = std::clamp(linear, 0.0, 1.0);
    const double encoded = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1.0 / 2.4) - 0.055;
    return static_cast<int>(std::lround(255.0 * encoded));
}

double linear_of(int code) {
    const double c = code / 255.0;
    return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}

}  // namespace camrig::render
