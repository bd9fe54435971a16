#include "core/render/software/shadowed_statics.h"

#include "core/render/software/shading.h"
#include "core/render/software/shadow_lookup.h"

namespace camrig::render::software {
namespace {

template <typename Isa>
CAMRIG_LANES void find_shadowed_body(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depths,
                                     Rows<std::uint32_t> numbers, Rows<std::uint32_t> to) {
    const auto farthest = geometry.farthest();
    const auto depth_shift = static_cast<float>(geometry.transform().depth_shift);
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0 & -lane_count; x < rect.x1; x += lane_count) {
            const IntLanes inside =
                ((int_lane_numbers() + (x - rect.x0)) | ((rect.x1 - 1 - x) - int_lane_numbers())) >= 0;
            const IntLanes number = load_lanes(numbers(y) + x);
            const IntLanes drawn = inside & (number != 0);
            if (Isa::bits(drawn) == 0) continue;
            const Lanes depth = reinterpret_cast<Lanes>(load_lanes(depths(y) + x));
            const Lanes z = depth_shift / (depth - farthest);
            const Lanes3 position = rays_through(geometry, x, y) * z;
            IntLanes shadowed{};
            for (const ShadowInView& map : geometry.shadows()) shadowed |= may_show_movers<Isa>(map, position);
            shadowed &= drawn;
            if (Isa::bits(shadowed) == 0) continue;
            store(to(y), x, shadowed, number);
        }
    }
}

CAMRIG_WIDE void find_shadowed_wide(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depths,
                                    Rows<std::uint32_t> numbers, Rows<std::uint32_t> to) {
    find_shadowed_body<Avx2Isa>(geometry, rect, depths, numbers, to);
}

}  // namespace

void find_shadowed(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depth, Rows<std::uint32_t> numbers,
                   Rows<std::uint32_t> to) {
    if (geometry.wide_lanes()) return find_shadowed_wide(geometry, rect, depth, numbers, to);
    find_shadowed_body<PlainIsa>(geometry, rect, depth, numbers, to);
}

}  // namespace camrig::render::software
