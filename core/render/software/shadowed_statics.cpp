#include "core/render/software/shadowed_statics.h"

#include <algorithm>
#include <cmath>

#include "core/render/software/contact_light.h"
#include "core/render/software/coverage.h"
#include "core/render/software/ray_pixels.h"
#include "core/render/software/shading.h"
#include "core/render/software/shadow_lookup.h"

namespace camrig::render::software {
namespace {

/// Whether movers may keep light from the points, of lamps or from all around.
template <typename Isa>
CAMRIG_LANES IntLanes may_be_shadowed(const ViewGeometry& geometry, const Lanes3& position) {
    IntLanes shadowed{};
    for (const ShadowInView& map : geometry.shadows()) shadowed |= may_show_movers<Isa>(map, position);
    if (geometry.bodies() != nullptr) shadowed |= may_be_darkened<Isa>(*geometry.bodies(), position);
    return shadowed;
}

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
            const IntLanes shadowed = drawn & may_be_shadowed<Isa>(geometry, position);
            if (Isa::bits(shadowed) == 0) continue;
            store(to(y), x, shadowed, number);
        }
    }
}

/// The ray through a place, and the depth of its triangle there, at the nearest subpixel.
struct PlaceInView {
    glm::vec3 ray;
    float depth;
};
PlaceInView place_in_view(const ViewGeometry& geometry, const ShadedPlace& place) {
    const double column = place.x / subpixels, row = place.y / subpixels;
    if (geometry.rays() != nullptr) {
        const auto x = static_cast<int>(std::lround(column)), y = static_cast<int>(std::lround(row));
        const PixelRay pixel(*geometry.rays(), x, y);
        const glm::vec3 ray =
            pixel.at + pixel.dx * static_cast<float>(column - x) + pixel.dy * static_cast<float>(row - y);
        const auto farthest = static_cast<float>(geometry.farthest());
        return {ray, along(geometry.ray_triangles()[place.triangle].depth, ray) + farthest};
    }
    const camera::Intrinsics& k = geometry.transform().intrinsics;
    const Setup s = set_up(geometry.vertices().data(), geometry.triangles()[place.triangle]);
    const DepthPlane plane = depth_plane(s);
    const auto x = static_cast<std::int64_t>(place.x), y = static_cast<std::int64_t>(place.y);
    return {{(column - k.cx) / k.fx, (row - k.cy) / k.fy, 1.0},
            static_cast<float>(plane.base + static_cast<double>(edge(s, 1, x, y)) * plane.second +
                               static_cast<double>(edge(s, 2, x, y)) * plane.third)};
}

template <typename Isa>
CAMRIG_LANES void find_shadowed_points_body(const ViewGeometry& geometry, std::span<const glm::vec3> positions,
                                            std::span<std::uint8_t> to) {
    for (std::size_t first = 0; first < positions.size(); first += lane_count) {
        const std::size_t count = std::min<std::size_t>(lane_count, positions.size() - first);
        Lanes3 position{};
        for (std::size_t i = 0; i < lane_count; ++i) {
            const glm::vec3& at = positions[first + std::min(i, count - 1)];
            const auto lane = static_cast<int>(i);
            position.x[lane] = at.x;
            position.y[lane] = at.y;
            position.z[lane] = at.z;
        }
        const IntLanes shadowed = may_be_shadowed<Isa>(geometry, position);
        for (std::size_t i = 0; i < count; ++i) to[first + i] = shadowed[static_cast<int>(i)] != 0;
    }
}
CAMRIG_WIDE void find_shadowed_points_wide(const ViewGeometry& geometry, std::span<const glm::vec3> positions,
                                           std::span<std::uint8_t> to) {
    find_shadowed_points_body<Avx2Isa>(geometry, positions, to);
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

void find_shadowed(const ViewGeometry& geometry, std::span<const glm::vec3> positions, std::span<std::uint8_t> to) {
    if (geometry.wide_lanes()) return find_shadowed_points_wide(geometry, positions, to);
    find_shadowed_points_body<PlainIsa>(geometry, positions, to);
}

std::vector<glm::vec3> positions_of(const ViewGeometry& geometry, std::span<const ShadedPlace> places) {
    const auto farthest = geometry.farthest();
    const auto depth_shift = static_cast<float>(geometry.transform().depth_shift);
    std::vector<glm::vec3> made;
    made.reserve(places.size());
    for (const ShadedPlace& place : places) {
        const PlaceInView at = place_in_view(geometry, place);
        made.push_back(at.ray * (depth_shift / (at.depth - static_cast<float>(farthest))));
    }
    return made;
}

}  // namespace camrig::render::software
