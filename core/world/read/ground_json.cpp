#include "core/world/read/ground_json.h"

#include "core/camera/pose.h"
#include "core/world/camera_json.h"
#include "core/world/route_path.h"
#include "core/world/world_fields.h"

namespace camrig::world {

using nlohmann::json;

namespace {

/// An array of this many coordinates; a z that is not given is 0.
Result<glm::dvec3> read_point(const json& value, std::size_t least, std::size_t most, const std::string& expected) {
    glm::dvec3 point(0.0);
    bool good = value.is_array() && value.size() >= least && value.size() <= most;
    for (std::size_t c = 0; good && c < value.size(); ++c) {
        good = value[c].is_number() && std::abs(value[c].get<double>()) <= camera::max_coordinate_m;
        if (good) point[static_cast<glm::length_t>(c)] = value[c].get<double>();
    }
    if (!good) return error(ErrorKind::invalid_argument, expected + " within 1e10 m");
    return point;
}

Result<glm::dvec3> read_route_point(const json& value, const std::string& path) {
    return read_point(value, 2, 3, path + ": expected [x, y] or [x, y, z]");
}

Result<std::vector<glm::dvec2>> read_polygon(const json& value, const std::string& path, std::string_view what) {
    if (!value.is_array() || value.size() > max_area_points)
        return error(ErrorKind::invalid_argument, path + ": expected an array of at most 2000 points");
    std::vector<glm::dvec2> corners;
    for (std::size_t i = 0; i < value.size(); ++i) {
        const auto point = read_point(value[i], 2, 2, item_path(path, i) + ": expected [x, y]");
        if (!point) return std::unexpected(point.error());
        corners.emplace_back(point->x, point->y);
    }
    if (corners.size() < 3)
        return error(ErrorKind::invalid_argument, path + ": " + std::string(what) + " has at least 3 points");
    return corners;
}

Result<std::vector<glm::dvec2>> read_border(const json& value, const std::string& path) {
    return read_polygon(value, path, "an area");
}
Result<std::vector<glm::dvec2>> read_obstacle(const json& value, const std::string& path) {
    return read_polygon(value, path, "an obstacle");
}

}  // namespace

FieldTable<Route> fields_of(std::type_identity<Route>) {
    static const std::vector<FieldOf<Route>> table{
        list_at<&Route::points>(
            {.name = "points",
             .type = "array of [x, y] or [x, y, z]",
             .doc = "2 to 2000, closed 3 to 2000; neighbours are at least 1 mm apart in the plane",
             .required = true,
             .unit = "m",
             .schema = R"({"type": "array", "items": {"type": "array", "items": {"$ref": "#/$defs/coordinate"},
                           "minItems": 2, "maxItems": 3}, "minItems": 2, "maxItems": 2000})"},
            max_route_points, read_route_point),
        field_at<&Route::closed>({.name = "closed", .doc = "the last point leads back to the first"})};
    return table;
}

FieldTable<Area> fields_of(std::type_identity<Area>) {
    static const std::vector<FieldOf<Area>> table{
        nested_at<&Area::points>({.name = "points",
                                  .type = "array of [x, y]",
                                  .doc = "its border, 3 to 2000; it does not cross itself",
                                  .required = true,
                                  .unit = "m",
                                  .schema = R"({"$ref": "#/$defs/polygon"})"},
                                 read_border),
        list_at<&Area::obstacles>(
            {.name = "obstacles",
             .type = "array of arrays of [x, y]",
             .doc =
                 "polygons that nobody walks through, at most 1000, of 4000 corners with those of the border; events "
                 "look at the border only",
             .unit = "m",
             .fallback = "none",
             .schema = R"({"type": "array", "items": {"$ref": "#/$defs/polygon"}, "maxItems": 1000})"},
            max_area_obstacles, read_obstacle),
        field_at<&Area::z>({.name = "z",
                            .doc = "height of the floor",
                            .unit = "m",
                            .range = {-camera::max_coordinate_m, camera::max_coordinate_m}})};
    return table;
}

FieldTable<Place> fields_of(std::type_identity<Place>) {
    static const std::vector<FieldOf<Place>> table{
        text_at<&Place::description>({.name = "description", .fallback = "\"\""}),
        nested_at<&Place::pose>(
            {.name = "pose", .doc = "as of a camera", .required = true, .schema = R"({"$ref": "#/$defs/pose"})"},
            read_pose),
        degrees_at<&Place::vfov_rad>(
            {.name = "vfov_deg", .doc = "vertical field of view", .fallback = "60", .range = {0.01, 179.9}})};
    return table;
}

Result<Route> read_route(const json& value, const std::string& path) {
    return read_all<Route>(value, path, [](const Route& route, JsonReader& reader) {
        if (auto walked = RoutePath::create(route); !walked) reader.fail_inside(walked.error());
    });
}

Result<Area> read_area(const json& value, const std::string& path) {
    return read_all<Area>(value, path, [](const Area& area, JsonReader& reader) {
        std::size_t corners = area.points.size();
        for (const auto& obstacle : area.obstacles) corners += obstacle.size();
        if (corners > max_area_corners)
            reader.fail("obstacles", "more than 4000 corners with those of the border", ErrorKind::resource_exhausted);
    });
}

}  // namespace camrig::world
