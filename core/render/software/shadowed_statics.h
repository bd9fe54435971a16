#pragma once

#include <span>
#include <vector>

#include "core/render/software/place_shading.h"
#include "core/render/software/rasterizer.h"

/// What stands still where the shadows of what moves fall on it.
namespace camrig::render::software {

/// What a static layer keeps to shade its pixels anew. Its picture is drawn as if nothing moved.
struct ShadowedStatics {
    ViewGeometry geometry;
    TriangleNumbers numbers;    ///< of its triangles
    std::uint32_t proxies = 0;  ///< so many of the first are not shaded (catchers.h)
    Plane<float> depth;         ///< of these triangles; empty: that of the layer

    std::int64_t bytes() const { return geometry.bytes(); }
};

/// Where movers may be in the way of the light of a pixel, sets its number in `to` to that of its static triangle.
/// depth: of what stands still.
void find_shadowed(const ViewGeometry& geometry, const PixelRect& rect, Rows<float> depth, Rows<std::uint32_t> numbers,
                   Rows<std::uint32_t> to);
/// The same of points: whether movers may be in the way of their light.
void find_shadowed(const ViewGeometry& geometry, std::span<const glm::vec3> positions, std::span<std::uint8_t> to);
/// Where places lie, in the optical frame.
std::vector<glm::vec3> positions_of(const ViewGeometry& geometry, std::span<const ShadedPlace> places);

}  // namespace camrig::render::software
