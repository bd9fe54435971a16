#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/render/scene/prepared_model.h"
#include "core/render/software/mesh_neighbors.h"
#include "core/render/view_transform.h"

/// From vertices in space to triangles on the screen, eight at a time.
namespace camrig::render::software {

/// In 1/256 of a pixel; the middle of pixel (x, y) is at (256 x, 256 y), as OpenCV counts.
inline constexpr int subpixels = 256;
/// Beyond, edges are clipped: coordinates stay below 2^23, their products below 2^53.
inline constexpr double guard_px = 16384.0;

struct ScreenVertex {
    std::int32_t x = 0, y = 0;
    float depth = 0.0f;      ///< reversed: 1 at the near plane, 0 at infinity
    float inverse_z = 0.0f;  ///< of metres along the optical axis
};

/// ScreenTriangle::draw has so many bits.
inline constexpr std::uint32_t max_draws = (1u << 28) - 1;

/// Its corners run so that the area is positive where x points right and y down.
struct ScreenTriangle {
    std::array<std::uint32_t, 3> vertices{};  ///< into ViewGeometry::vertices
    std::uint32_t draw : 28 = 0;              ///< into ViewGeometry::draws
    std::uint32_t outline : 3 = 0;   ///< bit i: the edge opposite of vertex i may be one of the surface's outline
    std::uint32_t is_front : 1 = 1;  ///< whether its front is seen
    double inverse_area = 0.0;       ///< 1 / twice its area, in subpixels
    std::int16_t x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< the pixels whose middles may be inside: x0 <= x < x1
};

/// Planes that a vertex is beyond, as bits.
inline constexpr std::int32_t outside_left = 1, outside_right = 2, outside_top = 4, outside_bottom = 8,
                              outside_near = 16, outside_guard = 32;

/// Where vertices lie on the screen, and what they are beyond. Those beyond the near plane or the guard lie anywhere.
/// `which`: into all three; `wide`: with instructions for all lanes at once (has_wide_lanes).
void project(const ViewTransform& view, const glm::dmat4& optical_from_local, const glm::vec3* positions,
             std::span<const std::uint32_t> which, bool wide, ScreenVertex* to, std::int32_t* outside);

/// How triangles of a draw become ScreenTriangle.
struct TriangleRule {
    std::uint32_t draw = 0;
    std::uint32_t first_vertex = 0;  ///< corners count from here in ViewGeometry::vertices
    bool turns_clockwise = false, is_double_sided = false;
    bool keeps_thin = false;                   ///< also triangles between the middles of pixels, and the outline
    const MeshNeighbors* neighbors = nullptr;  ///< of the triangles; null: every edge is of the outline
};

/// What assemble() works with when the outline is kept.
struct OutlineScratch {
    std::vector<std::uint8_t> facing;    ///< of each triangle of the mesh
    std::vector<std::uint32_t> sources;  ///< which of them those that were appended come from
};

/// How a triangle's corners turn on the screen; of one that is nowhere it is not known.
inline constexpr std::uint8_t facing_unknown = 0, facing_straight = 1, facing_turned = 2;

/// An edge of a triangle is inside of the outline if the triangle beyond it is there and faces the same way. triangles:
/// those that scratch.sources names.
void find_outline(const MeshNeighbors& neighbors, const OutlineScratch& scratch, std::span<ScreenTriangle> triangles);

/// Appends the triangles that may show a pixel; those that must be clipped first go to `to_clip`,
/// and the rest nowhere. `vertices` and `outside`: from rule.first_vertex on.
void assemble(const scene::TriangleCorners& corners, const ScreenVertex* vertices, const std::int32_t* outside,
              const TriangleRule& rule, bool wide, OutlineScratch& scratch, std::vector<ScreenTriangle>& to,
              scene::TriangleCorners& to_clip);

}  // namespace camrig::render::software
