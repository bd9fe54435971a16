#include "core/world/route_path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/portable_math.h"
#include "core/world/turn.h"

namespace camrig::world {
namespace {

constexpr double min_piece_m = 1e-3;
constexpr double max_length_m = 1e9;
constexpr double max_turn_rad = 175.0 * std::numbers::pi / 180.0;

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
    return portable::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

glm::dvec3 horizontal(const glm::dvec3& v) {
    return {v.x, v.y, 0.0};
}

std::string point_name(std::size_t i) {
    return "points[" + std::to_string(i) + "]";
}

}  // namespace

Result<RoutePath> RoutePath::create(const Route& route, double radius_m) {
    const auto& points = route.points;
    const std::size_t count = points.size();
    const auto wrong = [](std::string message) { return error(ErrorKind::invalid_argument, std::move(message)); };
    if (count < (route.closed ? 3u : 2u))
        return wrong(route.closed ? "points: a closed route has at least 3" : "points: a route has at least 2");

    const std::size_t legs = route.closed ? count : count - 1;
    std::vector<glm::dvec3> direction(legs);
    std::vector<double> length(legs);
    double total = 0.0;
    for (std::size_t i = 0; i < legs; ++i) {
        const glm::dvec3 leg = points[(i + 1) % count] - points[i];
        length[i] = glm::length(leg);
        if (!(glm::length(horizontal(leg)) >= min_piece_m))
            return wrong(point_name(i) + ": the next point is not at least 1 mm away in the plane");
        direction[i] = leg / length[i];
        total += length[i];
    }
    if (!(total <= max_length_m)) return wrong("points: the route is longer than 1e9 m");

    // What the rounding takes off the legs before and after corner i, which stands at points[i].
    std::vector<double> cut(count, 0.0);
    const auto leg_before = [&](std::size_t corner) { return (corner + legs - 1) % legs; };
    for (std::size_t i = route.closed ? 0 : 1; i < (route.closed ? count : count - 1); ++i) {
        const std::size_t before = leg_before(i);
        if (angle_between(horizontal(direction[before]), horizontal(direction[i])) > max_turn_rad)
            return wrong(point_name(i) +
                         ": the route turns back on itself; end it there and walk it in mode ping_pong");
        const double turn = angle_between(direction[before], direction[i]);
        cut[i] = std::min({radius_m * portable::tan(turn / 2.0), length[before] / 2.0, length[i] / 2.0});
    }

    RoutePath path;
    for (std::size_t i = 0; i < legs; ++i) {
        const std::size_t end = (i + 1) % count;
        path.append({.length_m = length[i] - cut[i] - cut[end],
                     .origin = points[i] + direction[i] * cut[i],
                     .u = direction[i]});
        if (!route.closed && i + 1 == legs) break;
        const std::size_t next = (i + 1) % legs;
        const double turn = angle_between(direction[i], direction[next]);
        if (!(turn > 1e-9) || !(cut[end] > 0.0)) continue;
        const double radius = cut[end] / portable::tan(turn / 2.0);
        const glm::dvec3 inward =
            glm::normalize(direction[next] - direction[i] * glm::dot(direction[i], direction[next]));
        path.append({.length_m = radius * turn,
                     .origin = points[end] - direction[i] * cut[end] + inward * radius,
                     .u = -inward,
                     .v = direction[i],
                     .radius_m = radius});
    }
    return path;
}

void RoutePath::append(Piece piece) {
    if (!(piece.length_m > 0.0)) return;
    piece.start_m = length_m_;
    length_m_ += piece.length_m;
    pieces_.push_back(piece);
}

RoutePath::Point RoutePath::at(double at_m) const {
    at_m = std::clamp(at_m, 0.0, length_m_);
    const auto after = std::upper_bound(pieces_.begin(), pieces_.end(), at_m,
                                        [](double m, const Piece& piece) { return m < piece.start_m; });
    const Piece& piece = *(after - 1);
    const double along = std::min(at_m - piece.start_m, piece.length_m);
    glm::dvec3 position, direction;
    if (piece.radius_m == 0.0) {
        position = piece.origin + piece.u * along;
        direction = piece.u;
    } else {
        const double angle = along / piece.radius_m;
        const double c = portable::cos(angle), s = portable::sin(angle);
        position = piece.origin + piece.radius_m * (piece.u * c + piece.v * s);
        direction = piece.v * c - piece.u * s;
    }
    return {position, yaw_of(glm::dvec2(direction))};
}

}  // namespace camrig::world
