#include "core/world/read/ground_json.h"

#include <cmath>

#include "core/world/camera_json.h"
#include "core/world/read/json_parts.h"
#include "core/world/route_path.h"

namespace camrig {

using nlohmann::json;

Result<Route> read_route(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    Route route;
    if (!reader.has("points")) reader.fail("points", "is missing");
    const auto points = reader.array("points", max_route_points);
    for (std::size_t i = 0; i < points.size(); ++i) {
        glm::dvec3 p(0.0);
        if (!read_point(points[i], p))
            reader.fail(item_path("points", i), "expected [x, y] or [x, y, z] within 1e10 m");
        route.points.push_back(p);
    }
    reader.optional("closed", route.closed);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    if (auto walked = RoutePath::create(route); !walked) {
        reader.fail_inside(walked.error());
        return std::unexpected(reader.finish().error());
    }
    return route;
}

namespace {

/// A polygon of at least three corners.
void read_polygon(JsonReader& reader, std::string_view key, std::span<const json> points, std::string_view what,
                  std::vector<glm::dvec2>& out) {
    for (std::size_t i = 0; i < points.size(); ++i) {
        glm::dvec3 p(0.0);
        if (points[i].size() != 2 || !read_point(points[i], p))
            reader.fail(item_path(key, i), "expected [x, y] within 1e10 m");
        out.emplace_back(p.x, p.y);
    }
    if (reader.ok(key) && out.size() < 3) reader.fail(key, std::string(what) + " has at least 3 points");
}

}  // namespace

Result<Area> read_area(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    Area area;
    if (!reader.has("points")) reader.fail("points", "is missing");
    read_polygon(reader, "points", reader.array("points", max_area_points), "an area", area.points);
    const auto obstacles = reader.array("obstacles", max_area_obstacles);
    for (std::size_t i = 0; i < obstacles.size(); ++i) {
        const std::string key = item_path("obstacles", i);
        if (!obstacles[i].is_array() || obstacles[i].size() > max_area_points) {
            reader.fail(key, "expected an array of at most 2000 points");
            continue;
        }
        const auto& corners = obstacles[i].get_ref<const json::array_t&>();
        read_polygon(reader, key, corners, "an obstacle", area.obstacles.emplace_back());
    }
    std::size_t corners = area.points.size();
    for (const auto& obstacle : area.obstacles) corners += obstacle.size();
    if (reader.ok() && corners > max_area_corners)
        reader.fail("obstacles", "more than 4000 corners with those of the border", ErrorKind::resource_exhausted);
    reader.optional("z", area.z);
    if (reader.ok("z") && std::abs(area.z) > max_coordinate_m) reader.fail("z", "expected a height within 1e10 m");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return area;
}

Result<Place> read_place(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    Place place;
    reader.optional("description", place.description);
    if (const json* pose = reader.find("pose")) {
        if (auto read = read_pose(*pose, path + ".pose"))
            place.pose = *read;
        else
            reader.fail(read.error());
    } else {
        reader.fail("pose", "is missing");
    }
    double vfov_deg = 60.0;
    optional_in_range(reader, "vfov_deg", vfov_deg, 0.01, 179.9);
    place.vfov_rad = glm::radians(vfov_deg);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return place;
}

}  // namespace camrig
