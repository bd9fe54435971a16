#pragma once

#include <cstddef>

#include "core/render/software/coverage.h"

/// What the corners of a triangle have, and how much of each a point has: by shares in the plane of the screen, or by
/// the rays of a lens.
namespace camrig::render::software {

/// A corner of a triangle of a draw.
struct Corner {
    std::uint32_t vertex;         ///< of the mesh
    const VertexValues* clipped;  ///< what clipping made; null: of the mesh
};

CAMRIG_LANES Corner corner_of(const ViewGeometry& geometry, const ViewDraw& draw, std::uint32_t vertex) {
    const std::uint32_t own = vertex - draw.first_vertex;
    if (own < draw.vertex_count) return {own, nullptr};
    return {own, &geometry.clipped()[draw.first_clipped + own - draw.vertex_count]};
}

/// Where the values of the vertices of a draw are.
struct CornerAttribute {
    const float* of_mesh;    ///< of the first vertex
    std::int32_t stride;     ///< to the next one's, in floats
    std::size_t of_clipped;  ///< in VertexValues, in bytes
};

CAMRIG_LANES const float* values_at(const Corner& corner, const CornerAttribute& attribute) {
    if (corner.clipped != nullptr)
        return reinterpret_cast<const float*>(reinterpret_cast<const std::byte*>(corner.clipped) +
                                              attribute.of_clipped);
    return attribute.of_mesh + static_cast<std::ptrdiff_t>(corner.vertex) * attribute.stride;
}

/// What of a RayTriangle the place of a point follows from. V is float or Lanes.
template <typename V>
struct RayEdges {
    struct {
        V x, y, z;
    } edges[3];
    V length;

    CAMRIG_LANES Lanes along(std::size_t i, const Lanes3& ray) const {
        return ray.x * edges[i].x + ray.y * edges[i].y + ray.z * edges[i].z;
    }
};

/// Rays of a group of points, and how they change to the next pixel on the right and below.
struct PointRays {
    Lanes3 at, dx, dy;
};
CAMRIG_LANES PointRays point_rays_at(const LensRays& rays, int x, int y) {
    const Lanes3 at = rays_at(rays, x, y);
    return {at, rays_at(rays, x + 1, y) - at, rays_at(rays, x, y + 1) - at};
}

/// The shares of the second and third vertex in the plane of the screen, and their steps. V is float or Lanes.
template <typename V>
struct ScreenShares {
    Lanes second, third;
    V second_dx, third_dx, second_dy, third_dy;
};

}  // namespace camrig::render::software
