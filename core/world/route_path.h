#pragma once

#include <vector>

#include "core/base/result.h"
#include "core/world/scene.h"

namespace camrig::world {

/// A route as a smooth path by arc length: straight pieces joined by circular arcs, so position and direction are
/// continuous. Length 0 is the first point of an open route; on a closed one it is where the rounding of the first
/// corner ends. Immutable; any thread.
class RoutePath {
public:
    struct Point {
        glm::dvec3 position;
        double heading_rad = 0.0;  ///< of the horizontal direction of travel, from +x, counter-clockwise
    };

    /// `radius_m` of the corners, less where the neighbouring pieces are short. Errors: fewer than 2 points (3 when
    /// closed), points on top of each other, vertical pieces, a corner that turns back by over 175 deg, a length over
    /// 1e9 m.
    static Result<RoutePath> create(const Route& route, double radius_m = 0.5);

    double length_m() const { return length_m_; }
    /// `at_m` is clamped to [0, length].
    Point at(double at_m) const;

private:
    struct Piece {
        double start_m = 0.0;
        double length_m = 0.0;
        glm::dvec3 origin{0.0};  ///< start of a line; centre of an arc
        glm::dvec3 u{0.0};       ///< line: direction; arc: unit vector from the centre to its start
        glm::dvec3 v{0.0};       ///< arc: direction at its start
        double radius_m = 0.0;   ///< 0: a line
    };
    void append(Piece piece);

    std::vector<Piece> pieces_;
    double length_m_ = 0.0;
};

}  // namespace camrig::world
