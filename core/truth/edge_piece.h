#pragma once

#include <array>
#include <optional>
#include <span>
#include <utility>

#include <glm/glm.hpp>

#include "core/camera/camera_model.h"

namespace camrig::truth {

/// A piece of the picture of a straight edge, seen through a lens that bends it: where its ends are, exactly, and a
/// rectangle that holds all of it.
struct EdgePiece {
    glm::dvec3 a{0.0}, b{0.0};  ///< the ends as EdgeTracer::Seen::place
    glm::dvec3 normal{0.0};     ///< equidistant: of the plane through edge and camera
    double length = 1.0;        ///< of the curve's parameter: 1, or the angle between the ends
    glm::dvec2 at_a{0.0}, at_b{0.0};
    glm::dvec2 min{0.0}, max{0.0};
};

/// Follows straight edges through the lens of one camera.
///
/// Edges are followed where they are simple: an edge is a straight line in the ideal plane of a plane model, and an arc
/// of a great circle for the equidistant one. Interval arithmetic on the lens's formulas bounds value and slope of the
/// picture along a piece; where the slope has one sign the ends are the extremes, else the two ends and the bounds of
/// the slope bound what is between (Piyavskii, USSR Comp. Math. and Math. Phys. 12, 1972). The rectangle of a piece
/// shrinks onto it with the square of its length.
class EdgeTracer {
public:
    /// `camera` must outlive it.
    explicit EdgeTracer(const camera::CameraModel& camera);

    /// A point that has a pixel.
    struct Seen {
        glm::dvec3 place{0.0};  ///< its ideal point (z is 0) or, equidistant, its unit direction
        glm::dvec2 pixel{0.0};
        double radius = 0.0;  ///< of its ideal point
    };
    /// None where a point of the optical frame is outside of the field.
    std::optional<Seen> see(const glm::dvec3& point) const;
    /// Pieces of the edge between two points of the optical frame (in front of the camera for plane models) that lie
    /// within the lens's field. They last until the next call.
    std::span<const EdgePiece> trace(const glm::dvec3& a, const glm::dvec3& b);
    std::pair<EdgePiece, EdgePiece> halves(const EdgePiece& piece) const;
    /// Pixels of picture per unit of distance between two places of which none is further than `radius` from the axis,
    /// and which are at most longest_step() apart, at most; infinite where that cannot be told.
    double reach(double radius) const;
    double longest_step() const;

private:
    glm::dvec2 pixel_of(const glm::dvec3& place) const;
    glm::dvec2 pixel_of_ideal(const glm::dvec2& ideal) const;
    void add(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& normal, double length);
    void trace_line(const glm::dvec3& a, const glm::dvec3& b);
    void trace_arc(const glm::dvec3& a, const glm::dvec3& b);
    void bound(EdgePiece& piece) const;

    const camera::CameraModel& camera_;
    bool angular_;
    double radius_;  ///< of the valid disc, a little less
    std::array<EdgePiece, 2> pieces_;
    std::size_t count_ = 0;
};

}  // namespace camrig::truth
