#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/render/software/lens_numbers.h"
#include "core/render/software/lens_rays.h"
#include "core/render/software/screen_triangles.h"

/// Triangles of a view through a lens, in the space of its rays: there their edges are straight, wherever they are.
namespace camrig::render::software {

/// More of what a vertex may be beyond: the end of the lens, and so far that no short edge from there is seen.
inline constexpr std::int32_t outside_end = 64, outside_lens = 128;

/// A vertex, and where the lens shows it. What it does not show lies anywhere.
struct LensVertex {
    glm::vec3 at{0.0f};         ///< in the optical frame
    std::int32_t x = 0, y = 0;  ///< in subpixels
    glm::vec2 ideal{0.0f};      ///< on the ideal plane of the lens
    std::int32_t outside = 0;   ///< planes that it is beyond, as bits
};

/// Which rays pass through a triangle, and where they meet it. Its corners run as those of a ScreenTriangle.
///
/// The edge opposite of a corner is the plane through the eye and the other two; ray . edge is the weight of the corner
/// where the ray meets the triangle, not yet divided by the sum of the three. For the triangle beyond it the same edge
/// is exactly the negative.
struct RayTriangle {
    std::array<glm::vec3, 3> edges;
    float length = 0.0f;                 ///< this over the sum of the weights is how many rays it is to the triangle
    glm::vec3 depth{0.0f};               ///< ray . depth is reversed depth, less that of what is infinitely far
    std::array<std::int32_t, 3> bias{};  ///< 0: a ray on the edge is inside; -1: it is not
};

/// Places vertices: `which` of the positions, into `to` at the same index. wide: with instructions for all lanes.
void place_vertices(const LensNumbers& lens, ImageSize size, const glm::dmat4& optical_from_local,
                    const glm::vec3* positions, std::span<const std::uint32_t> which, bool wide, LensVertex* to);

/// Appends the triangles that may show a pixel, and what their rays are. Vertices: from rule.first_vertex on.
void assemble_rays(const scene::TriangleCorners& corners, const LensVertex* vertices, const TriangleRule& rule,
                   const LensNumbers& lens, const LensRays& rays, bool wide, OutlineScratch& scratch,
                   std::vector<ScreenTriangle>& to, std::vector<RayTriangle>& rays_to);

}  // namespace camrig::render::software
