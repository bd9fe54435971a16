#pragma once

#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/render/support/test_rig.h"

/// The same picture by camrig's rasteriser ("cpu") and by OpenGL ("llvmpipe").
namespace camrig::render {

/// One per device and test program.
inline Renderer& renderer_of(const std::string& device) {
    // Two GL contexts on one thread would be in each other's way; the device cpu makes none for colour alone.
    static std::map<std::string, std::unique_ptr<Renderer>> renderers;
    auto& renderer = renderers[device];
    if (renderer == nullptr)
        renderer = std::move(create_renderer({.device = device, .pool = std::make_shared<frame::FramePool>()}).value());
    return *renderer;
}

inline frame::FrameRef drawn_by(const std::string& device, const world::SnapshotRef& snapshot, const View& view) {
    Renderer& renderer = renderer_of(device);
    return renderer.draw(snapshot, 0, {&view, 1}).value().set.frames.at(0);
}

/// The instance picture of a view.
inline frame::FrameRef ids_of(const world::SnapshotRef& snapshot, View view) {
    view.camera = CameraId{static_cast<std::uint32_t>(view.camera) + 1000};
    view.kinds[static_cast<int>(frame::FrameKind::color)] = false;
    view.kinds[static_cast<int>(frame::FrameKind::instance)] = true;
    return drawn_by("cpu", snapshot, view);
}

inline constexpr int alike_codes = 3;

/// Colours of two pictures, pixel by pixel.
struct Alike {
    int pixels = 0;
    int alike = 0;  ///< no channel is more than `alike_codes` away

    double share() const { return static_cast<double>(alike) / std::max(1, pixels); }
};
/// ids: those objects alone, as the instance picture `shown` has them; empty: all.
inline Alike alike(const frame::FrameRef& a, const frame::FrameRef& b, const std::vector<std::uint32_t>& ids = {},
                   const frame::FrameRef& shown = nullptr) {
    Alike result;
    const auto count = static_cast<std::size_t>(a->info().size.pixels());
    const auto* const id_of =
        shown == nullptr ? nullptr : reinterpret_cast<const std::uint32_t*>(shown->bytes().data());
    for (std::size_t i = 0; i < count; ++i) {
        if (!ids.empty() && std::ranges::find(ids, id_of[i]) == ids.end()) continue;
        bool is_alike = true;
        for (std::size_t c = 4 * i; c < 4 * i + 3; ++c)
            is_alike &=
                std::abs(std::to_integer<int>(a->bytes()[c]) - std::to_integer<int>(b->bytes()[c])) <= alike_codes;
        ++result.pixels;
        result.alike += is_alike;
    }
    return result;
}

/// Almost all of a view, or of some objects of it, is the same but for rounding: where an edge passes, either of two
/// colours is right.
inline void expect_alike(const world::SnapshotRef& snapshot, const View& view, const std::string& what,
                         const std::vector<std::uint32_t>& ids = {}) {
    const frame::FrameRef shown = ids.empty() ? nullptr : ids_of(snapshot, view);
    const Alike found = alike(drawn_by("cpu", snapshot, view), drawn_by("llvmpipe", snapshot, view), ids, shown);
    std::printf("%s: %.2f %% of %d pixels within %d codes\n", what.c_str(), 100.0 * found.share(), found.pixels,
                alike_codes);
    EXPECT_GE(found.pixels, 200) << what;
    EXPECT_GE(found.share(), 0.99) << what;
}

}  // namespace camrig::render
