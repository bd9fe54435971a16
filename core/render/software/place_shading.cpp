#include "core/render/software/place_shading.h"

#include <algorithm>

#include "core/render/software/shading.h"
#include "core/render/software/surface_point.h"

namespace camrig::render::software {
namespace {

template <typename Isa>
CAMRIG_LANES void shade_places_body(const ViewGeometry& geometry, ShadedPlaces& of, bool has_movers) {
    const camera::Intrinsics& k = geometry.transform().intrinsics;
    const auto count = static_cast<std::uint32_t>(of.order.size());
    for (std::uint32_t first = 0, end = 0; first < count; first = end) {
        const std::uint32_t number = geometry.triangles()[of.places[of.order[first]].triangle].draw;
        end = std::min(first + lane_count, of.first_of_draw[number + 1]);
        const ViewDraw& draw = geometry.draws()[number];
        IntLanes triangle{};
        Lanes share{};
        Doubles x{}, y{};
        for (int lane = 0; lane < lane_count; ++lane) {
            const auto at = std::min(first + static_cast<std::uint32_t>(lane), end - 1);
            const ShadedPlace& place = of.places[of.order[at]];
            triangle[lane] = static_cast<std::int32_t>(place.triangle) + 1;
            share[lane] = place.share;
            (lane < 4 ? x.low : x.high)[lane % 4] = place.x;
            (lane < 4 ? y.low : y.high)[lane % 4] = place.y;
        }
        const TriangleAtPlaces<Isa> at(geometry, draw, triangle, x, y, share);
        constexpr double pixels = 1.0 / subpixels;
        const Lanes3 rays = geometry.rays() != nullptr
                                ? at.point_rays(0, 0).at
                                : Lanes3{narrowed((x * pixels + -k.cx) * (1.0 / k.fx)),
                                         narrowed((y * pixels + -k.cy) * (1.0 / k.fy)), lanes(1.0f)};
        Rgba color = shade<Isa>(geometry, draw, points_of(geometry, draw, at, 0, 0), rays, has_movers);
        if (of.are_blended) {
            const Lanes alpha = clamp01(color.a);
            color.rgb = color.rgb * alpha;
            color.tint = color.tint * (1.0f - alpha);
        }
        for (std::uint32_t i = first; i < end; ++i) {
            const auto lane = static_cast<int>(i - first);
            of.colors[of.order[i]] = {color.rgb.x[lane], color.rgb.y[lane], color.rgb.z[lane]};
            if (of.are_blended) of.through[of.order[i]] = {color.tint.x[lane], color.tint.y[lane], color.tint.z[lane]};
        }
    }
}

CAMRIG_WIDE void shade_places_wide(const ViewGeometry& geometry, ShadedPlaces& of, bool has_movers) {
    shade_places_body<Avx2Isa>(geometry, of, has_movers);
}

}  // namespace

void shade_places(const ViewGeometry& geometry, ShadedPlaces& of, bool has_movers) {
    // Sorted by draw: how many each has, then where each one's begin.
    of.first_of_draw.assign(geometry.draws().size() + 2, 0);
    const auto draw_of = [&](const ShadedPlace& place) { return geometry.triangles()[place.triangle].draw; };
    for (const ShadedPlace& place : of.places) ++of.first_of_draw[draw_of(place) + 2];
    for (std::size_t i = 2; i < of.first_of_draw.size(); ++i) of.first_of_draw[i] += of.first_of_draw[i - 1];
    of.order.resize(of.places.size());
    for (std::uint32_t i = 0; i < of.places.size(); ++i) of.order[of.first_of_draw[draw_of(of.places[i]) + 1]++] = i;
    of.colors.resize(of.places.size());
    if (of.are_blended) of.through.resize(of.places.size());
    if (geometry.wide_lanes()) return shade_places_wide(geometry, of, has_movers);
    shade_places_body<PlainIsa>(geometry, of, has_movers);
}

}  // namespace camrig::render::software
