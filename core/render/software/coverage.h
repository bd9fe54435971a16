#pragma once

#include <algorithm>
#include <array>

#include "core/render/software/geometry.h"
#include "core/render/software/lanes.h"
#include "core/render/software/pixel_part.h"
#include "core/render/software/ray_coverage.h"

/// Which pixels a triangle covers, and at what depth.
namespace camrig::render::software {

/// The edges of a triangle; each lies opposite of the vertex it weighs. Through a lens it has others, and these are not
/// set.
struct Setup {
    const RayTriangle* ray = nullptr;
    std::array<const ScreenVertex*, 3> at{};
    std::array<std::int32_t, 3> dx{}, dy{};
    double inverse_area = 0.0;
};

CAMRIG_LANES std::int64_t edge(const Setup& s, std::size_t i, std::int64_t x, std::int64_t y) {
    const ScreenVertex& from = *s.at[(i + 1) % 3];
    return s.dx[i] * (y - from.y) - s.dy[i] * (x - from.x);
}

CAMRIG_LANES Setup set_up(const ScreenVertex* vertices, const ScreenTriangle& triangle) {
    Setup s;
    for (std::size_t i = 0; i < 3; ++i) s.at[i] = vertices + triangle.vertices[i];
    for (std::size_t i = 0; i < 3; ++i) {
        const ScreenVertex &from = *s.at[(i + 1) % 3], &to = *s.at[(i + 2) % 3];
        s.dx[i] = to.x - from.x;
        s.dy[i] = to.y - from.y;
    }
    s.inverse_area = triangle.inverse_area;
    return s;
}

/// Of a triangle of a view, from 0.
CAMRIG_LANES Setup set_up(const ViewGeometry& geometry, std::uint32_t number) {
    if (geometry.rays() == nullptr) return set_up(geometry.vertices().data(), geometry.triangles()[number]);
    Setup s;
    s.ray = &geometry.ray_triangles()[number];
    return s;
}

/// Depth is linear on the screen: at the first pixel of a group from its edges, in double, then along the row.
struct DepthPlane {
    double base, second, third;
    float dx;
};

CAMRIG_LANES DepthPlane depth_plane(const Setup& s) {
    const double base = s.at[0]->depth;
    const double second = (s.at[1]->depth - base) * s.inverse_area, third = (s.at[2]->depth - base) * s.inverse_area;
    return {base, second, third,
            static_cast<float>(-subpixels *
                               (static_cast<double>(s.dy[1]) * second + static_cast<double>(s.dy[2]) * third))};
}

/// How depth changes about any pixel; at its centre it is left to be set.
CAMRIG_LANES PixelPlane depth_steps(const Setup& s, const DepthPlane& depth) {
    constexpr float step = 1.0f / 128.0f;
    const auto dy = static_cast<float>(
        subpixels * (static_cast<double>(s.dx[1]) * depth.second + static_cast<double>(s.dx[2]) * depth.third));
    return {0.0f, depth.dx * step, dy * step};
}

CAMRIG_LANES Lanes depth_at(const DepthPlane& plane, std::int64_t second_edge, std::int64_t third_edge) {
    const double base =
        plane.base + static_cast<double>(second_edge) * plane.second + static_cast<double>(third_edge) * plane.third;
    return static_cast<float>(base) + lane_numbers() * plane.dx;
}

/// Those of the rectangle whose centres may be inside; may be none.
CAMRIG_LANES PixelRect pixels_of(const ScreenTriangle& triangle, const PixelRect& rect) {
    return {std::max<int>(rect.x0, triangle.x0), std::max<int>(rect.y0, triangle.y0),
            std::min<int>(rect.x1, triangle.x1), std::min<int>(rect.y1, triangle.y1)};
}

/// Calls visit(x, y, mask, depth) for all groups of pixels of a row that a triangle covers; x is a multiple of
/// lane_count. rect: of pixels_of, not empty.
template <typename Isa, typename Visit>
CAMRIG_LANES void rasterize(const Setup& s, const PixelRect& rect, const Visit& visit) {
    const auto [x0, y0, x1, y1] = rect;
    const DepthPlane depth = depth_plane(s);
    const int first = x0 & -lane_count;
    std::array<std::int64_t, 3> row{};   // at the first pixel of a row, of the groups
    std::array<std::int32_t, 3> bias{};  // a centre on an edge that is neither top nor left is outside
    for (std::size_t i = 0; i < 3; ++i) {
        const bool is_top_left = s.dy[i] < 0 || (s.dy[i] == 0 && s.dx[i] > 0);
        bias[i] = is_top_left ? 0 : -1;
        row[i] = edge(s, i, std::int64_t{first} * subpixels, std::int64_t{y0} * subpixels);
    }
    const IntLanes from = int_lane_numbers();
    constexpr int small = 1 << 14;  // its edges fit into 32 bits
    const auto is_short = [](std::int32_t length) { return length > -small && length < small; };
    if (std::ranges::all_of(s.dx, is_short) && std::ranges::all_of(s.dy, is_short)) {
        std::array<IntLanes, 3> across{};
        for (std::size_t i = 0; i < 3; ++i) across[i] = from * (-s.dy[i] * subpixels);
        for (int y = y0; y < y1; ++y) {
            std::array<std::int32_t, 3> at{static_cast<std::int32_t>(row[0]), static_cast<std::int32_t>(row[1]),
                                           static_cast<std::int32_t>(row[2])};
            for (int x = first; x < x1; x += lane_count) {
                const IntLanes outside = (across[0] + (at[0] + bias[0])) | (across[1] + (at[1] + bias[1])) |
                                         (across[2] + (at[2] + bias[2])) | (from + (x - x0)) | ((x1 - 1 - x) - from);
                const IntLanes mask = outside >= 0;
                if (Isa::bits(mask) != 0) visit(x, y, mask, depth_at(depth, at[1], at[2]));
                for (std::size_t i = 0; i < 3; ++i) at[i] -= s.dy[i] * subpixels * lane_count;
            }
            for (std::size_t i = 0; i < 3; ++i) row[i] += std::int64_t{s.dx[i]} * subpixels;
        }
        return;
    }
    for (int y = y0; y < y1; ++y) {
        // The pixels of the row that are inside of all three edges.
        int begin = x0, end = x1;
        for (std::size_t i = 0; i < 3; ++i) {
            const std::int64_t value = row[i] + bias[i], step = -std::int64_t{s.dy[i]} * subpixels;
            if (step == 0) {
                if (value < 0) end = begin;
            } else if (step > 0) {
                if (value < 0)
                    begin = std::max<std::int64_t>(
                        begin, first + std::min<std::int64_t>((-value + step - 1) / step, x1 - first));
            } else {
                end = value < 0 ? begin : static_cast<int>(std::min<std::int64_t>(end, first + value / -step + 1));
            }
        }
        for (int x = begin & -lane_count; x < end; x += lane_count) {
            const IntLanes mask = ((from + (x - begin)) | ((end - 1 - x) - from)) >= 0;
            const std::int64_t steps = std::int64_t{x - first} * subpixels;
            visit(x, y, mask, depth_at(depth, row[1] - s.dy[1] * steps, row[2] - s.dy[2] * steps));
        }
        for (std::size_t i = 0; i < 3; ++i) row[i] += std::int64_t{s.dx[i]} * subpixels;
    }
}

/// Of a triangle of a view, whether there is a lens or not.
template <typename Isa, typename Visit>
CAMRIG_LANES void rasterize(const ViewGeometry& geometry, const Setup& s, const PixelRect& rect, const Visit& visit) {
    if (s.ray != nullptr) return rasterize<Isa>(*geometry.rays(), *s.ray, geometry.farthest(), rect, visit);
    rasterize<Isa>(s, rect, visit);
}

}  // namespace camrig::render::software
