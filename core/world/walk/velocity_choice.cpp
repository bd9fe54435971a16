#include "core/world/walk/velocity_choice.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <vector>

namespace camrig::world {
namespace {

constexpr double parallel = 1e-9;
constexpr double slack = 1e-9;

glm::dvec2 left_of(const glm::dvec2& v) {
    return {-v.y, v.x};
}

glm::dvec2 unit_or(const glm::dvec2& v, const glm::dvec2& otherwise) {
    const double length = glm::length(v);
    return length > 1e-12 ? v / length : otherwise;
}

/// What is looked for: the point nearest to `target`, or, as a direction, the farthest that way.
struct Goal {
    glm::dvec2 target;
    bool is_direction = false;
};

bool obeys(const HalfPlane& plane, const glm::dvec2& v) {
    return glm::dot(plane.normal, v) >= plane.offset - slack;
}

/// The best point on the border of planes[i] that obeys the planes before it; nothing when there is none.
std::optional<glm::dvec2> best_on_border(std::span<const HalfPlane> planes, std::size_t i, const Goal& goal,
                                         double max_speed) {
    const HalfPlane& border = planes[i];
    const double half2 = max_speed * max_speed - border.offset * border.offset;
    if (half2 < 0.0) return std::nullopt;
    const glm::dvec2 foot = border.normal * border.offset, along = left_of(border.normal);
    double low = -std::sqrt(half2), high = std::sqrt(half2);
    for (std::size_t j = 0; j < i; ++j) {
        const double rate = glm::dot(planes[j].normal, along);
        const double need = planes[j].offset - glm::dot(planes[j].normal, foot);
        if (std::abs(rate) < parallel) {
            if (need > slack) return std::nullopt;
        } else if (rate > 0.0) {
            low = std::max(low, need / rate);
        } else {
            high = std::min(high, need / rate);
        }
        if (low > high) return std::nullopt;
    }
    const double t = goal.is_direction ? (glm::dot(goal.target, along) > 0.0 ? high : low)
                                       : std::clamp(glm::dot(goal.target - foot, along), low, high);
    return foot + along * t;
}

/// The best velocity of all; `obeyed` is how many of the planes it obeys for certain, all when there is an answer.
glm::dvec2 best(std::span<const HalfPlane> planes, const Goal& goal, double max_speed, std::size_t& obeyed) {
    const double length = glm::length(goal.target);
    glm::dvec2 v = goal.target;
    if (goal.is_direction || length > max_speed) v = unit_or(goal.target, {1.0, 0.0}) * max_speed;
    for (obeyed = 0; obeyed < planes.size(); ++obeyed) {
        if (obeys(planes[obeyed], v)) continue;
        const auto on_border = best_on_border(planes, obeyed, goal, max_speed);
        if (!on_border) return v;
        v = *on_border;
    }
    return v;
}

/// From the first plane that cannot be obeyed on: breaks the worst of planes[hard...] as little as can be. For each
/// plane k that is broken more than the worst so far, the velocities that break k no less than any other before it are
/// a half-plane each, and among them the one that breaks k least is a linear program again.
glm::dvec2 least_broken(std::span<const HalfPlane> planes, std::size_t hard, std::size_t from, glm::dvec2 v,
                        double max_speed) {
    double worst = 0.0;
    std::vector<HalfPlane> among;
    for (std::size_t k = from; k < planes.size(); ++k) {
        const HalfPlane& plane = planes[k];
        if (plane.offset - glm::dot(plane.normal, v) <= worst + slack) continue;
        among.assign(planes.begin(), planes.begin() + static_cast<std::ptrdiff_t>(hard));
        for (std::size_t j = hard; j < k; ++j) {
            const glm::dvec2 normal = planes[j].normal - plane.normal;
            const double length = glm::length(normal);
            if (length < parallel) continue;
            among.push_back({normal / length, (planes[j].offset - plane.offset) / length});
        }
        std::size_t obeyed = 0;
        const glm::dvec2 found = best(among, {plane.normal, true}, max_speed, obeyed);
        if (obeyed == among.size()) v = found;  // else: rounding; what there is will do
        worst = plane.offset - glm::dot(plane.normal, v);
    }
    return v;
}

}  // namespace

HalfPlane avoid(const Encounter& other, const glm::dvec2& own_velocity, double horizon_s, double overlap_s) {
    const glm::dvec2 p = other.position, v = own_velocity - other.velocity;
    const double distance2 = glm::dot(p, p), radius = other.radius;
    glm::dvec2 normal;   // out of the velocity obstacle, at its point nearest to v
    double depth = 0.0;  // how deep v is inside; below 0: outside
    const auto from_disc = [&](double time_s) {
        const glm::dvec2 w = v - p / time_s;
        normal = unit_or(w, unit_or(-p, {1.0, 0.0}));
        depth = radius / time_s - glm::length(w);
    };
    if (distance2 <= radius * radius) {
        from_disc(overlap_s);
    } else {
        // The obstacle is a cone with its tip cut off by a disc about p / horizon.
        const glm::dvec2 w = v - p / horizon_s;
        const double forward = glm::dot(w, p);
        if (forward < 0.0 && forward * forward > radius * radius * glm::dot(w, w)) {
            from_disc(horizon_s);
        } else {
            const double leg = std::sqrt(distance2 - radius * radius);
            const bool left = p.x * w.y - p.y * w.x > 0.0;
            const glm::dvec2 side = left ? left_of(p) : -left_of(p);
            const glm::dvec2 edge = (p * leg + side * radius) / distance2;
            normal = left ? left_of(edge) : -left_of(edge);
            depth = -glm::dot(v, normal);
        }
    }
    const glm::dvec2 point = own_velocity + normal * (depth * other.share);
    return {normal, glm::dot(point, normal)};
}

HalfPlane keep_off(const glm::dvec2& to_wall, double radius, double horizon_s) {
    const double distance = glm::length(to_wall);
    return {-unit_or(to_wall, {1.0, 0.0}), -(distance - radius) / horizon_s};
}

glm::dvec2 choose_velocity(std::span<const HalfPlane> planes, std::size_t hard, const glm::dvec2& wanted,
                           double max_speed) {
    std::size_t obeyed = 0;
    const glm::dvec2 v = best(planes, {wanted, false}, max_speed, obeyed);
    if (obeyed == planes.size()) return v;
    return least_broken(planes, obeyed < hard ? 0 : hard, obeyed, v, max_speed);
}

}  // namespace camrig::world
