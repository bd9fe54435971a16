#include "core/world/read/check_walkable.h"

#include <algorithm>
#include <string>
#include <vector>

#include <glm/gtx/exterior_product.hpp>

#include "core/world/backdrop/backdrop.h"
#include "core/world/walk/walk_area.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

using Polygon = std::vector<glm::dvec2>;

constexpr std::size_t max_walkable_corners = 20'000;
/// On the border is inside.
constexpr double touch_m = 1e-6;

/// Where on the way from a to b, from 0 to 1, it crosses or touches a side of the polygons: 0 and 1 are among them.
std::vector<double> crossings(const std::vector<Polygon>& ground, const glm::dvec2& a, const glm::dvec2& b) {
    std::vector<double> shares{0.0, 1.0};
    const glm::dvec2 way = b - a;
    for (const Polygon& polygon : ground) {
        for (std::size_t i = 0; i < polygon.size(); ++i) {
            const glm::dvec2 from = polygon[i], side = polygon[(i + 1) % polygon.size()] - from;
            const double turn = glm::cross(way, side);
            if (turn == 0.0) continue;
            const double share = glm::cross(from - a, side) / turn, along = glm::cross(from - a, way) / turn;
            if (share > 0.0 && share < 1.0 && along >= -1e-9 && along <= 1.0 + 1e-9) shares.push_back(share);
        }
    }
    std::ranges::sort(shares);
    return shares;
}

double distance_to(const Polygon& polygon, const glm::dvec2& p) {
    double least = 1e300;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const glm::dvec2 from = polygon[i], side = polygon[(i + 1) % polygon.size()] - from;
        const double length2 = glm::dot(side, side);
        const double share = length2 == 0.0 ? 0.0 : std::clamp(glm::dot(p - from, side) / length2, 0.0, 1.0);
        least = std::min(least, glm::length(p - (from + share * side)));
    }
    return least;
}

bool is_walkable(const std::vector<Polygon>& ground, const glm::dvec2& p) {
    return std::ranges::any_of(
        ground, [&](const Polygon& polygon) { return inside(polygon, p) || distance_to(polygon, p) <= touch_m; });
}

bool is_way_walkable(const std::vector<Polygon>& ground, const glm::dvec2& a, const glm::dvec2& b) {
    const std::vector<double> shares = crossings(ground, a, b);
    for (std::size_t i = 1; i < shares.size(); ++i)
        if (!is_walkable(ground, a + 0.5 * (shares[i - 1] + shares[i]) * (b - a))) return false;
    return true;
}

/// Where the file says what is walkable.
std::string said_at(std::size_t camera) {
    return item_path("cameras", camera) + ".backdrop.proxies.walkable";
}

}  // namespace

std::optional<Error> find_unwalkable(const Scene& scene) {
    std::vector<Polygon> ground;
    std::size_t corners = 0, first_camera = scene.cameras.size();
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
        if (scene.cameras[i].backdrop_here == nullptr) continue;
        for (const Polygon& polygon : scene.cameras[i].backdrop_here->walkable) {
            first_camera = std::min(first_camera, i);
            corners += polygon.size();
            ground.push_back(polygon);
        }
    }
    const std::string said = said_at(first_camera);
    if (corners > max_walkable_corners)
        return Error{ErrorKind::resource_exhausted,
                     said + ": more than " + std::to_string(max_walkable_corners) + " corners in all cameras"};
    if (ground.empty()) return std::nullopt;
    const auto check = [&](const std::string& path, const auto& points, bool is_closed) -> std::optional<Error> {
        const std::string what = " what is walkable (" + said + "); move it, or add ground there";
        for (std::size_t i = 0; i < points.size(); ++i)
            if (!is_walkable(ground, glm::dvec2(points[i])))
                return Error{ErrorKind::invalid_argument, item_path(path, i) + ": is outside of" + what};
        const std::size_t ways = is_closed || points.empty() ? points.size() : points.size() - 1;
        for (std::size_t i = 0; i < ways; ++i)
            if (!is_way_walkable(ground, glm::dvec2(points[i]), glm::dvec2(points[(i + 1) % points.size()])))
                return Error{ErrorKind::invalid_argument,
                             item_path(path, i) + ": the way to the next point leaves" + what};
        return std::nullopt;
    };
    for (const auto& [name, route] : scene.routes)
        if (auto wrong = check("routes." + name + ".points", route.points, route.closed)) return wrong;
    for (const auto& [name, area] : scene.areas)
        if (auto wrong = check("areas." + name + ".points", area.points, true)) return wrong;
    return std::nullopt;
}

std::optional<std::string> why_unwalkable(const Scene& scene, const glm::dvec3& place) {
    // Programs that steer ask with each step: nothing is copied.
    std::size_t said_by = scene.cameras.size();
    for (std::size_t i = 0; i < scene.cameras.size(); ++i) {
        const auto& backdrop = scene.cameras[i].backdrop_here;
        if (backdrop == nullptr || backdrop->walkable.empty()) continue;
        if (is_walkable(backdrop->walkable, glm::dvec2(place))) return std::nullopt;
        said_by = std::min(said_by, i);
    }
    if (said_by == scene.cameras.size()) return std::nullopt;
    return "is outside of what is walkable (" + said_at(said_by) + "); give a place on it, or add ground there";
}

}  // namespace camrig::world
