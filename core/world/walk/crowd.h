#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include <glm/glm.hpp>

namespace camrig::world {

/// What one actor takes of the floor, as others see it: a capsule about position +- axis.
struct Body {
    std::uint32_t id = 0;
    glm::dvec2 position{0.0};
    glm::dvec2 velocity{0.0};
    glm::dvec2 axis{0.0};  ///< half the length of the capsule's straight part, along the front
    double z = 0.0;
    double radius = 0.0;
    bool gives_way = false;  ///< avoids others too, so each does half of it

    /// The point of the capsule's axis that is nearest to p.
    glm::dvec2 nearest(const glm::dvec2& p) const;
};

/// All bodies of a step, to be found by place: a grid of square cells, kept as a sorted list. Thread: the world's.
class Crowd {
public:
    void assign(std::vector<Body> bodies);
    const std::vector<Body>& bodies() const { return bodies_; }
    /// The bodies whose position is within `range` of p (and some beyond), in an order that depends on them alone.
    void near(const glm::dvec2& p, double range, std::vector<const Body*>& out) const;
    /// Half the length of the longest body.
    double longest() const { return longest_; }

private:
    std::vector<Body> bodies_;
    std::vector<std::pair<std::int64_t, std::uint32_t>> cells_;  ///< cell and index, sorted
    double longest_ = 0.0;
};

}  // namespace camrig::world
