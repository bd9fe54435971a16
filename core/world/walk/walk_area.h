#pragma once

#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/world/scene.h"

namespace camrig::world {

/// Whether p lies inside of the polygon (even-odd rule).
bool inside(const std::vector<glm::dvec2>& polygon, const glm::dvec2& p);

/// An area to walk in: distances to its walls, and ways round them. Immutable; any thread.
class WalkArea {
public:
    /// `clearance_m`: how far the middle of a walker keeps from walls when it plans its way.
    WalkArea(const Area& area, double clearance_m);

    double z() const { return area_.z; }
    const glm::dvec2& low() const { return low_; }
    const glm::dvec2& high() const { return high_; }

    /// Inside the border and outside the obstacles.
    bool contains(const glm::dvec2& p) const;
    /// From p to the nearest point of each wall that is within `range`.
    void walls_near(const glm::dvec2& p, double range, std::vector<glm::dvec2>& out) const;
    /// To the nearest wall.
    double wall_distance(const glm::dvec2& p) const;
    /// Whether a walker of this clearance can go straight from a to b.
    bool is_straight_clear(const glm::dvec2& a, const glm::dvec2& b) const;
    /// Whether p is a place to walk to: inside, and `clearance` from the walls.
    bool has_room(const glm::dvec2& p) const;

    /// Corners of a short way from a to b, b last; when there is none, b alone. A* over a grid of squares, in integers,
    /// then corners that can be left out are.
    std::vector<glm::dvec2> find_way(const glm::dvec2& a, const glm::dvec2& b) const;

private:
    struct Wall {
        glm::dvec2 from, to;
    };
    int cell_at(const glm::dvec2& p) const;
    glm::dvec2 middle_of(int cell) const;
    int nearest_free(int cell) const;
    std::vector<int> find_cells(int from, int to) const;

    Area area_;
    double clearance_;
    std::vector<Wall> walls_;
    glm::dvec2 low_{0.0}, high_{0.0};
    double cell_m_ = 0.25;
    int columns_ = 1, rows_ = 1;
    std::vector<std::uint8_t> is_free_;  ///< per cell
};

}  // namespace camrig::world
