#include "core/world/walk/crowd.h"

#include <algorithm>
#include <cmath>

namespace camrig::world {
namespace {

constexpr double cell_m = 2.0;
/// Beyond this, coordinates share the outermost cells: slow, still right.
constexpr double far_cells = 1e9;

std::int64_t cell_of(double coordinate) {
    return static_cast<std::int64_t>(std::clamp(std::floor(coordinate / cell_m), -far_cells, far_cells));
}

/// Cells of one row (equal y) follow each other.
std::int64_t key_of(std::int64_t x, std::int64_t y) {
    return y * (std::int64_t{1} << 32) + x;
}

}  // namespace

glm::dvec2 Body::nearest(const glm::dvec2& p) const {
    const double length2 = glm::dot(axis, axis);
    if (!(length2 > 0.0)) return position;
    return position + axis * std::clamp(glm::dot(p - position, axis) / length2, -1.0, 1.0);
}

void Crowd::assign(std::vector<Body> bodies) {
    bodies_ = std::move(bodies);
    cells_.clear();
    longest_ = 0.0;
    for (std::size_t i = 0; i < bodies_.size(); ++i) {
        const Body& body = bodies_[i];
        cells_.emplace_back(key_of(cell_of(body.position.x), cell_of(body.position.y)), static_cast<std::uint32_t>(i));
        longest_ = std::max(longest_, glm::length(body.axis) + body.radius);
    }
    std::ranges::sort(cells_);
}

void Crowd::near(const glm::dvec2& p, double range, std::vector<const Body*>& out) const {
    out.clear();
    const std::int64_t x0 = cell_of(p.x - range), x1 = cell_of(p.x + range);
    const std::int64_t y0 = cell_of(p.y - range), y1 = cell_of(p.y + range);
    if (static_cast<std::size_t>(y1 - y0) > cells_.size()) {  // a row each would be slower than all of them
        for (const Body& body : bodies_) out.push_back(&body);
        return;
    }
    for (std::int64_t y = y0; y <= y1; ++y) {
        auto it = std::ranges::lower_bound(cells_, std::pair(key_of(x0, y), std::uint32_t{0}));
        for (; it != cells_.end() && it->first <= key_of(x1, y); ++it) out.push_back(&bodies_[it->second]);
    }
}

}  // namespace camrig::world
