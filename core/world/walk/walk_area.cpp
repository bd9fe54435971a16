#include "core/world/walk/walk_area.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

#include <glm/gtx/exterior_product.hpp>

namespace camrig::world {
namespace {

constexpr double finest_cell_m = 0.2;
constexpr double max_cells = 40'000.0;
/// Integer lengths of a step along an axis and across: A* compares no rounded numbers.
constexpr int straight_cost = 10, across_cost = 14;

glm::dvec2 nearest_on(const glm::dvec2& from, const glm::dvec2& to, const glm::dvec2& p) {
    const glm::dvec2 along = to - from;
    const double length2 = glm::dot(along, along);
    if (!(length2 > 0.0)) return from;
    return from + along * std::clamp(glm::dot(p - from, along) / length2, 0.0, 1.0);
}

bool segments_cross(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    return glm::cross(b - a, c - a) * glm::cross(b - a, d - a) < 0.0 &&
           glm::cross(d - c, a - c) * glm::cross(d - c, b - c) < 0.0;
}

double segment_distance(const glm::dvec2& a, const glm::dvec2& b, const glm::dvec2& c, const glm::dvec2& d) {
    if (segments_cross(a, b, c, d)) return 0.0;
    return std::min({glm::distance(nearest_on(a, b, c), c), glm::distance(nearest_on(a, b, d), d),
                     glm::distance(nearest_on(c, d, a), a), glm::distance(nearest_on(c, d, b), b)});
}

}  // namespace

bool inside(const std::vector<glm::dvec2>& polygon, const glm::dvec2& p) {
    bool in = false;
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
        const glm::dvec2 &a = polygon[i], &b = polygon[j];
        if ((a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y)) in = !in;
    }
    return in;
}

WalkArea::WalkArea(const Area& area, double clearance_m) : area_(area), clearance_(clearance_m) {
    const auto add = [this](const std::vector<glm::dvec2>& polygon) {
        for (std::size_t i = 0; i < polygon.size(); ++i)
            walls_.push_back({polygon[i], polygon[(i + 1) % polygon.size()]});
    };
    add(area_.points);
    for (const auto& obstacle : area_.obstacles) add(obstacle);
    low_ = high_ = area_.points.front();
    for (const glm::dvec2& p : area_.points) {
        low_ = glm::min(low_, p);
        high_ = glm::max(high_, p);
    }
    const glm::dvec2 size = high_ - low_;
    cell_m_ = std::max({finest_cell_m, std::sqrt(size.x * size.y / max_cells), std::max(size.x, size.y) / 4000.0});
    columns_ = std::max(1, static_cast<int>(std::ceil(size.x / cell_m_)));
    rows_ = std::max(1, static_cast<int>(std::ceil(size.y / cell_m_)));
    is_free_.resize(static_cast<std::size_t>(columns_) * static_cast<std::size_t>(rows_));
    for (int cell = 0; cell < columns_ * rows_; ++cell)
        is_free_[static_cast<std::size_t>(cell)] = has_room(middle_of(cell)) ? 1 : 0;
}

bool WalkArea::contains(const glm::dvec2& p) const {
    if (!inside(area_.points, p)) return false;
    return std::ranges::none_of(area_.obstacles, [&](const auto& obstacle) { return inside(obstacle, p); });
}

void WalkArea::walls_near(const glm::dvec2& p, double range, std::vector<glm::dvec2>& out) const {
    out.clear();
    for (const Wall& wall : walls_) {
        const glm::dvec2 to = nearest_on(wall.from, wall.to, p) - p;
        if (glm::dot(to, to) <= range * range) out.push_back(to);
    }
}

double WalkArea::wall_distance(const glm::dvec2& p) const {
    double distance = std::numeric_limits<double>::max();
    for (const Wall& wall : walls_) distance = std::min(distance, glm::distance(nearest_on(wall.from, wall.to, p), p));
    return distance;
}

bool WalkArea::has_room(const glm::dvec2& p) const {
    return contains(p) && wall_distance(p) >= clearance_;
}

bool WalkArea::is_straight_clear(const glm::dvec2& a, const glm::dvec2& b) const {
    return std::ranges::all_of(walls_,
                               [&](const Wall& w) { return segment_distance(a, b, w.from, w.to) >= clearance_; });
}

int WalkArea::cell_at(const glm::dvec2& p) const {
    const glm::dvec2 at = (p - low_) / cell_m_;
    const int column = static_cast<int>(std::clamp(std::floor(at.x), 0.0, static_cast<double>(columns_ - 1)));
    const int row = static_cast<int>(std::clamp(std::floor(at.y), 0.0, static_cast<double>(rows_ - 1)));
    return row * columns_ + column;
}

glm::dvec2 WalkArea::middle_of(int cell) const {
    return low_ + cell_m_ * glm::dvec2(cell % columns_ + 0.5, cell / columns_ + 0.5);
}

int WalkArea::nearest_free(int cell) const {
    if (is_free_[static_cast<std::size_t>(cell)]) return cell;
    const int column = cell % columns_, row = cell / columns_;
    for (int ring = 1; ring < std::max(columns_, rows_); ++ring) {
        int found = -1;
        double nearest = std::numeric_limits<double>::max();
        for (int y = std::max(0, row - ring); y <= std::min(rows_ - 1, row + ring); ++y) {
            const bool is_edge_row = std::abs(y - row) == ring;
            for (int x = column - ring; x <= column + ring; x += is_edge_row ? 1 : 2 * ring) {
                const int here = y * columns_ + x;
                if (x < 0 || x >= columns_ || !is_free_[static_cast<std::size_t>(here)]) continue;
                const double distance = glm::distance(middle_of(here), middle_of(cell));
                if (distance < nearest) {
                    nearest = distance;
                    found = here;
                }
            }
        }
        if (found >= 0) return found;
    }
    return -1;
}

std::vector<int> WalkArea::find_cells(int from, int to) const {
    const auto steps_to_goal = [&](int cell) {
        const int dx = std::abs(cell % columns_ - to % columns_), dy = std::abs(cell / columns_ - to / columns_);
        return straight_cost * std::max(dx, dy) + (across_cost - straight_cost) * std::min(dx, dy);
    };
    std::vector<int> cost(is_free_.size(), std::numeric_limits<int>::max()), came_from(is_free_.size(), -1);
    using Open = std::pair<int, int>;  // estimated cost, cell: equal estimates are taken by cell
    std::priority_queue<Open, std::vector<Open>, std::greater<>> open;
    cost[static_cast<std::size_t>(from)] = 0;
    open.emplace(steps_to_goal(from), from);
    while (!open.empty()) {
        const auto [estimate, cell] = open.top();
        open.pop();
        if (cell == to) break;
        const int here = cost[static_cast<std::size_t>(cell)];
        if (estimate > here + steps_to_goal(cell)) continue;
        const int column = cell % columns_, row = cell / columns_;
        for (int dy = -1; dy <= 1; ++dy) {
            for (int dx = -1; dx <= 1; ++dx) {
                const int x = column + dx, y = row + dy;
                if (x < 0 || y < 0 || x >= columns_ || y >= rows_) continue;
                const int next = y * columns_ + x;
                const int there = here + (dx != 0 && dy != 0 ? across_cost : straight_cost);
                if (!is_free_[static_cast<std::size_t>(next)] || there >= cost[static_cast<std::size_t>(next)])
                    continue;
                cost[static_cast<std::size_t>(next)] = there;
                came_from[static_cast<std::size_t>(next)] = cell;
                open.emplace(there + steps_to_goal(next), next);
            }
        }
    }
    std::vector<int> cells;
    if (cost[static_cast<std::size_t>(to)] == std::numeric_limits<int>::max()) return cells;
    for (int cell = to; cell >= 0; cell = came_from[static_cast<std::size_t>(cell)]) cells.push_back(cell);
    std::ranges::reverse(cells);
    return cells;
}

std::vector<glm::dvec2> WalkArea::find_way(const glm::dvec2& a, const glm::dvec2& b) const {
    if (is_straight_clear(a, b)) return {b};
    const int from = nearest_free(cell_at(a)), to = nearest_free(cell_at(b));
    if (from < 0 || to < 0) return {b};
    std::vector<glm::dvec2> points{a};
    for (const int cell : find_cells(from, to)) points.push_back(middle_of(cell));
    if (has_room(b) || points.size() == 1) points.push_back(b);
    std::vector<glm::dvec2> way;
    for (std::size_t at = 0; at + 1 < points.size();) {
        std::size_t next = points.size() - 1;
        while (next > at + 1 && !is_straight_clear(points[at], points[next])) --next;
        way.push_back(points[next]);
        at = next;
    }
    return way;
}

}  // namespace camrig::world
