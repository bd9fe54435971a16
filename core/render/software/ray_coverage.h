#pragma once

#include <bit>

#include "core/render/software/lanes.h"
#include "core/render/software/ray_triangles.h"
#include "core/render/software/rows.h"

/// coverage.h for pictures through a lens: which pixels' rays pass through a triangle, and at what depth.
namespace camrig::render::software {

CAMRIG_LANES Lanes lanes_at(const float* from) {
    return reinterpret_cast<Lanes>(load_lanes(from));
}

/// Of pixel (x, y) and those right of it.
CAMRIG_LANES Lanes3 rays_at(const LensRays& rays, int x, int y) {
    const LensRays::Coordinates of = rays.rays();
    return {lanes_at(of.x(y) + x), lanes_at(of.y(y) + x), lanes_at(of.z(y) + x)};
}

/// Between these are all rays of eight tiles or blocks in a row.
struct RayBounds {
    Lanes3 low, high;
};
CAMRIG_LANES RayBounds bounds_at(const LensRays::Grid& grid, int column, int row) {
    const auto of = [&](const Plane<float>& plane)
                        __attribute__((always_inline)) { return lanes_at(plane.rows()(row) + column); };
    return {{of(grid.low_x), of(grid.low_y), of(grid.low_z)}, {of(grid.high_x), of(grid.high_y), of(grid.high_z)}};
}

CAMRIG_LANES Lanes along(const glm::vec3& of, const Lanes3& ray) {
    return ray.x * of.x + ray.y * of.y + ray.z * of.z;
}

/// Not less than along() of any ray within the bounds: the same operations, and rounding is monotonic.
CAMRIG_LANES Lanes most_along(const glm::vec3& of, const RayBounds& rays) {
    return max(rays.low.x * of.x, rays.high.x * of.x) + max(rays.low.y * of.y, rays.high.y * of.y) +
           max(rays.low.z * of.z, rays.high.z * of.z);
}

/// Not negative where a ray is inside of an edge. Not of a number: any.
CAMRIG_LANES IntLanes inside_of(const RayTriangle& triangle, std::size_t i, const Lanes3& ray) {
    // No -0: its bits are those of a negative number.
    return reinterpret_cast<IntLanes>(along(triangle.edges[i], ray) + 0.0f) + triangle.bias[i];
}

/// In which of eight tiles or blocks the triangle may show, as bits.
template <typename Isa>
CAMRIG_LANES unsigned may_show(const RayTriangle& triangle, float farthest, const RayBounds& rays) {
    const Lanes nothing{};
    return Isa::bits(
        (most_along(triangle.edges[0], rays) >= nothing) & (most_along(triangle.edges[1], rays) >= nothing) &
        (most_along(triangle.edges[2], rays) >= nothing) & (most_along(triangle.depth, rays) + farthest > nothing));
}

CAMRIG_LANES float most_of(const glm::vec3& of, const glm::vec3& reach) {
    const glm::vec3 most = glm::abs(of) * reach;
    return most.x + most.y + most.z;
}

/// In which of eight tiles or blocks the triangle may touch a pixel, also beside its centre, as bits. outline: not 0:
/// in which one of these edges may.
template <typename Isa>
CAMRIG_LANES unsigned may_touch(const RayTriangle& triangle, float farthest, const glm::vec3& reach, unsigned outline,
                                const RayBounds& rays) {
    IntLanes touches = most_along(triangle.depth, rays) + (farthest + most_of(triangle.depth, reach)) > 0.0f;
    IntLanes has_edge = outline == 0 ? IntLanes{} - 1 : IntLanes{};
    for (std::size_t i = 0; i < 3; ++i) {
        const float slack = most_of(triangle.edges[i], reach);
        touches &= most_along(triangle.edges[i], rays) >= -slack;
        if ((outline >> i & 1) != 0) has_edge |= -most_along(-triangle.edges[i], rays) <= slack;
    }
    return Isa::bits(touches & has_edge);
}

/// Calls visit(rect) for the parts of the rectangle, each inside of one tile, of which may(bounds) has the bit.
template <typename Isa, typename May, typename Visit>
CAMRIG_LANES void each_tile(const LensRays& rays, const PixelRect& rect, const May& may, const Visit& visit) {
    constexpr int block = LensRays::block_side, tile = LensRays::tile_side;
    for (int row = rect.y0 / block; row * block < rect.y1; ++row) {
        for (int first = rect.x0 / block & -lane_count; first * block < rect.x1; first += lane_count) {
            unsigned blocks = may(bounds_at(rays.blocks(), first, row));
            for (; blocks != 0; blocks &= blocks - 1) {
                const int column = first + std::countr_zero(blocks);
                const PixelRect in_block =
                    common(rect, {column * block, row * block, (column + 1) * block, (row + 1) * block});
                if (in_block.width() <= 0) continue;
                for (int y = in_block.y0 / tile; y * tile < in_block.y1; ++y) {
                    unsigned tiles = may(bounds_at(rays.tiles(), column * lane_count, y));
                    for (; tiles != 0; tiles &= tiles - 1) {
                        const int x = column * lane_count + std::countr_zero(tiles);
                        const PixelRect in_tile =
                            common(in_block, {x * tile, y * tile, (x + 1) * tile, (y + 1) * tile});
                        if (in_tile.width() > 0) visit(in_tile);
                    }
                }
            }
        }
    }
}

/// What is no larger touches few tiles, and needs no look at their bounds.
CAMRIG_LANES bool touches_few_tiles(const PixelRect& rect) {
    constexpr int large = 24;
    return rect.width() <= large && rect.height() <= large;
}

/// rasterize() in coverage.h through a lens. farthest: depth of what is infinitely far.
template <typename Isa, typename Visit>
CAMRIG_LANES void rasterize(const LensRays& rays, const RayTriangle& triangle, float farthest, const PixelRect& rect,
                            const Visit& visit) {
    const IntLanes from = int_lane_numbers();
    const auto visit_part = [&](const PixelRect& part) __attribute__((always_inline)) {
        for (int x = part.x0 & -lane_count; x < part.x1; x += lane_count) {
            const IntLanes beside = (from + (x - part.x0)) | ((part.x1 - 1 - x) - from);
            for (int y = part.y0; y < part.y1; ++y) {
                const Lanes3 ray = rays_at(rays, x, y);
                const IntLanes outside =
                    inside_of(triangle, 0, ray) | inside_of(triangle, 1, ray) | inside_of(triangle, 2, ray) | beside;
                const Lanes depth = along(triangle.depth, ray) + farthest;
                // Before the near plane nothing shows.
                const IntLanes mask = (outside >= 0) & (depth <= 1.0f);
                if (Isa::bits(mask) != 0) visit(x, y, mask, depth);
            }
        }
    };
    if (touches_few_tiles(rect)) return visit_part(rect);
    const auto may = [&](const RayBounds& bounds)
                         __attribute__((always_inline)) { return may_show<Isa>(triangle, farthest, bounds); };
    each_tile<Isa>(rays, rect, may, visit_part);
}

}  // namespace camrig::render::software
