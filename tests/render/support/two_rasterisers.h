#pragma once

#include <algorithm>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/frame/kind_format.h"
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

/// Colours of two pictures, pixel by pixel.
struct Alike {
    int pixels = 0;
    int alike = 0;  ///< no channel is more than `tolerance` codes away

    double share() const { return static_cast<double>(alike) / std::max(1, pixels); }
};
/// ids: those objects alone, as the instance picture `shown` has them; empty: all.
inline Alike alike(const frame::FrameRef& a, const frame::FrameRef& b, int tolerance,
                   const std::vector<std::uint32_t>& ids = {}, const frame::FrameRef& shown = nullptr) {
    Alike result;
    const auto count = static_cast<std::size_t>(a->info().size.pixels());
    const auto* const id_of =
        shown == nullptr ? nullptr : reinterpret_cast<const std::uint32_t*>(shown->bytes().data());
    for (std::size_t i = 0; i < count; ++i) {
        if (!ids.empty() && std::ranges::find(ids, id_of[i]) == ids.end()) continue;
        bool is_alike = true;
        for (std::size_t c = 4 * i; c < 4 * i + 3; ++c)
            is_alike &=
                std::abs(std::to_integer<int>(a->bytes()[c]) - std::to_integer<int>(b->bytes()[c])) <= tolerance;
        ++result.pixels;
        result.alike += is_alike;
    }
    return result;
}

}  // namespace camrig::render
