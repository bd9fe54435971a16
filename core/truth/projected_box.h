#pragma once

#include <limits>
#include <optional>
#include <span>
#include <vector>

#include <glm/glm.hpp>

#include "core/camera/camera_model.h"
#include "core/world/model.h"

namespace camrig {

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
/// bent, so they are followed in pieces of at most max_chord_px, whose ends are exact; between them a curve of radius r
/// bulges by max_chord_px^2 / (8 r), which for r = 25 px, near the fold of a very strong lens, is 0.08 px. Plane models
/// see what lies between the near and far planes; a fisheye (equidistant) sees what is inside of its field, at any
/// distance.
class BoxProjector {
public:
    /// far_m 0: no far plane.
    BoxProjector(const CameraModel& camera, double near_m, double far_m);

    /// Grows `box` by a primitive whose vertices are at `points` in the optical frame.
    void add(std::span<const glm::dvec3> points, const Primitive& primitive, ProjectedBox& box) const;

    static constexpr double max_chord_px = 4.0;

private:
    using Pixel = std::optional<glm::dvec2>;
    Pixel pixel_of(const glm::dvec3& point) const;
    bool between_planes(const glm::dvec3& point) const;
    void add_segment(glm::dvec3 a, glm::dvec3 b, ProjectedBox& box) const;
    void add_triangle(const glm::dvec3 (&corners)[3], bool is_whole, ProjectedBox& box) const;
    void add_rim(const glm::dvec3 (&corners)[3], ProjectedBox& box) const;
    void walk(const glm::dvec3& a, const Pixel& at_a, const glm::dvec3& b, const Pixel& at_b, int depth,
              ProjectedBox& box) const;

    struct RimPoint {
        glm::dvec3 direction;
        glm::dvec2 pixel;
    };

    const CameraModel& camera_;
    bool has_planes_;
    bool bends_;  ///< the lens bends straight lines
    double near_m_;
    double far_m_;
    double field_angle_;
    std::vector<RimPoint> rim_;  ///< the edge of the lens's field; empty where planes end it first
};

}  // namespace camrig
