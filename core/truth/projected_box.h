#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/base/result.h"
#include "core/camera/camera_model.h"
#include "core/truth/edge_piece.h"
#include "core/world/model.h"

namespace camrig::truth {

/// The smallest upright rectangle around something in the picture plane.
struct ProjectedBox {
    glm::dvec2 min{std::numeric_limits<double>::infinity()};
    glm::dvec2 max{-std::numeric_limits<double>::infinity()};
    bool is_clipped = false;  ///< part of it had no place in the picture plane

    bool is_empty() const { return !(min.x <= max.x); }
    void grow(glm::dvec2 pixel) {
        min = glm::min(min, pixel);
        max = glm::max(max, pixel);
    }
};

/// Where surfaces fall in the picture plane of one camera, through its lens, in double and unbounded by the picture.
///
/// Exact for a pinhole: the picture of a triangle ends where its edges do. Through other lenses straight edges are
/// bent: the box holds the pictures of all vertices, and interval arithmetic tells which edges may reach beyond it, and
/// by how much at most. The one that may most is halved until none may by more than the tolerance, so the box is never
/// larger than the true one and smaller by the tolerance at most: tolerance_px, and for boxes of more than 1000 px
/// tolerance_share of their side. Plane models see what lies between the near and far planes; a fisheye (equidistant)
/// sees what is inside of its field, at any distance.
///
/// The work is bounded: linear in the triangles, and max_halvings of edges in all for one projector.
class BoxProjector {
public:
    /// far_m 0: no far plane. `camera` must outlive it.
    BoxProjector(const camera::CameraModel& camera, double near_m, double far_m);

    /// Grows `box` by a primitive whose vertices are at `points` in the optical frame. resource_exhausted when the
    /// halvings are used up; `box` is then short by what the message says.
    Result<void> add(std::span<const glm::dvec3> points, const world::Primitive& primitive, ProjectedBox& box);

    std::int64_t halvings() const { return halvings_; }

    static constexpr double tolerance_px = 1e-4;
    static constexpr double tolerance_share = 1e-7;
    static constexpr std::int64_t max_halvings = 200'000;

private:
    using Seen = EdgeTracer::Seen;
    /// A piece of an edge whose picture may reach beyond the box.
    struct Candidate {
        EdgePiece piece;
        double excess = 0.0;
    };
    struct RimPoint {
        glm::dvec3 direction;
        glm::dvec2 pixel;
    };

    bool between_planes(const glm::dvec3& point) const;
    double greatest_radius() const;
    void add_surface(std::span<const std::uint32_t> corners, std::span<const glm::dvec3> points, ProjectedBox& box);
    bool may_reach_rim(std::span<const std::uint32_t> corners) const;
    bool stays_inside(const Seen& a, const Seen& b, const ProjectedBox& box) const;
    void add_edge(const glm::dvec3& a, const glm::dvec3& b, ProjectedBox& box);
    void add_rim(const glm::dvec3 (&corners)[3], ProjectedBox& box) const;
    static double excess_of(const EdgePiece& piece, const ProjectedBox& box);
    void consider(const EdgePiece& piece, const ProjectedBox& box);
    Result<void> halve_the_worst(ProjectedBox& box);

    const camera::CameraModel& camera_;
    EdgeTracer tracer_;
    bool has_planes_;
    bool bends_;  ///< the lens bends straight lines
    double near_m_;
    double far_m_;
    double field_angle_;
    std::vector<RimPoint> rim_;  ///< the edge of the lens's field; empty where planes end it first
    std::int64_t halvings_ = 0;

    // Of the primitive that is being added.
    std::vector<std::optional<Seen>> seen_;  ///< per vertex
    double reach_ = 0.0;                     ///< Lipschitz bound of the projection, pixels per unit
    std::vector<Candidate> candidates_;      ///< a heap, the worst on top
};

}  // namespace camrig::truth
