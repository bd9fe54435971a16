#include "core/world/backdrop/backdrop_spec.h"

#include "core/camera/pose.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

using nlohmann::json;

constexpr std::size_t max_polygon_points = 200;
constexpr double most_items = 200;
constexpr double most_m = camera::max_coordinate_m;
constexpr double least_box_m = 1e-3, most_box_m = 1e5;

constexpr const char* polygon_schema =
    R"({"type": "array", "items": {"type": "array", "items": {"$ref": "#/$defs/coordinate"}, "minItems": 2,
        "maxItems": 2}, "maxItems": 200})";

json numbers_of(const glm::dvec2& v) {
    return {v.x, v.y};
}
json numbers_of(const glm::dvec3& v) {
    return {v.x, v.y, v.z};
}

Result<glm::dvec2> read_corner(const json& value, const std::string& path) {
    const bool good = value.is_array() && value.size() == 2 && value[0].is_number() && value[1].is_number();
    const glm::dvec2 corner = good ? glm::dvec2(value[0].get<double>(), value[1].get<double>()) : glm::dvec2(0.0);
    if (!good || !(std::abs(corner.x) <= most_m && std::abs(corner.y) <= most_m))
        return error(ErrorKind::invalid_argument, path + ": expected [x, y] within 1e10");
    return corner;
}

/// A list of corners; empty where a polygon may be left out.
template <auto member>
auto polygon_at(Field field) {
    field.type = "array of [x, y]";
    field.schema = polygon_schema;
    if (!field.required) field.fallback = "[]";
    auto entry = list_at<member>(std::move(field), max_polygon_points, read_corner);
    entry.write = [](const auto& from) {
        json corners = json::array();
        for (const glm::dvec2& corner : from.*member) corners.push_back(numbers_of(corner));
        return corners;
    };
    return entry;
}

/// A list of structs with tables.
template <auto member>
auto structs_at(Field field) {
    using Item = typename MemberPointer<decltype(member)>::Value::value_type;
    field.type = "array of objects";
    field.parts = descriptions_of<Item>();
    field.fallback = "[]";
    field.range = {.high = most_items};
    field.is_whole = true;
    auto entry =
        list_at<member>(std::move(field), static_cast<std::size_t>(most_items),
                        [](const json& value, const std::string& path) { return read_all<Item>(value, path); });
    entry.write = [](const auto& from) {
        json items = json::array();
        for (const Item& item : from.*member) items.push_back(json_of(item));
        return items;
    };
    return entry;
}

/// Two or three numbers.
template <auto member>
auto numbers_at(Field field, double low, double high) {
    using V = typename MemberPointer<decltype(member)>::Value;
    field.type = V::length() == 2 ? "[x, y]" : "[x, y, z]";
    field.schema = V::length() == 2 ? R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2})"
                                    : R"({"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3})";
    auto entry = entry_by<member>(std::move(field), [low, high](JsonReader& reader, std::string_view key, V& out) {
        reader.required(key, std::span<double>(&out[0], static_cast<std::size_t>(V::length())));
        for (glm::length_t i = 0; i < V::length(); ++i)
            if (reader.ok(key) && !(out[i] >= low && out[i] <= high))
                reader.fail(key, "must be " + Range{low, high}.words());
    });
    entry.write = [](const auto& from) { return numbers_of(from.*member); };
    return entry;
}

template <typename T>
auto ground_height() {
    return field_at<&T::z>({.name = "z", .doc = "height of the ground", .unit = "m", .range = {-most_m, most_m}});
}

}  // namespace

std::span<const Named<BackdropKind>> names_of(std::type_identity<BackdropKind>) {
    static constexpr Named<BackdropKind> names[] = {{BackdropKind::plate, "plate"}};
    return names;
}

std::span<const Named<SceneInBackdrop>> names_of(std::type_identity<SceneInBackdrop>) {
    static constexpr Named<SceneInBackdrop> names[] = {
        {SceneInBackdrop::drawn, "drawn"}, {SceneInBackdrop::proxies, "proxies"}, {SceneInBackdrop::hidden, "hidden"}};
    return names;
}

FieldTable<GroundProxy> fields_of(std::type_identity<GroundProxy>) {
    static const std::vector<FieldOf<GroundProxy>> table{
        polygon_at<&GroundProxy::polygon_m>({.name = "polygon_m", .doc = "its corners in the world", .unit = "m"}),
        polygon_at<&GroundProxy::polygon_px>(
            {.name = "polygon_px", .doc = "instead: its corners in the picture, below the horizon", .unit = "px"}),
        ground_height<GroundProxy>()};
    return table;
}

FieldTable<BoxProxy> fields_of(std::type_identity<BoxProxy>) {
    static const std::vector<FieldOf<BoxProxy>> table{
        numbers_at<&BoxProxy::position>(
            {.name = "position", .doc = "the middle of its bottom", .required = true, .unit = "m"}, -most_m, most_m),
        numbers_at<&BoxProxy::size>({.name = "size", .doc = "along its x, y and z", .required = true, .unit = "m"},
                                    least_box_m, most_box_m),
        field_at<&BoxProxy::yaw_deg>(
            {.name = "yaw_deg", .doc = "about z, counter-clockwise", .unit = "deg", .range = {-360, 360}})};
    return table;
}

FieldTable<CutoutProxy> fields_of(std::type_identity<CutoutProxy>) {
    static const std::vector<FieldOf<CutoutProxy>> table{
        polygon_at<&CutoutProxy::polygon_px>(
            {.name = "polygon_px", .doc = "its outline in the picture", .required = true, .unit = "px"}),
        numbers_at<&CutoutProxy::foot_px>({.name = "foot_px",
                                           .doc = "where it stands on the ground, below the horizon",
                                           .required = true,
                                           .unit = "px"},
                                          -1e6, 1e6),
        ground_height<CutoutProxy>()};
    return table;
}

FieldTable<ProxiesSpec> fields_of(std::type_identity<ProxiesSpec>) {
    static const std::vector<FieldOf<ProxiesSpec>> table{
        field_at<&ProxiesSpec::file>(
            {.name = "file",
             .doc = ".glb or .gltf, placed in the world as it is; beside `file` of the picture. Empty: none"}),
        field_at<&ProxiesSpec::ground>({.name = "ground",
                                        .doc = "a piece of level ground, by one of the polygons",
                                        .null = "none",
                                        .shape = "GroundProxy",
                                        .is_whole = true}),
        structs_at<&ProxiesSpec::boxes>({.name = "boxes", .doc = "that stand in the place", .shape = "BoxProxy"}),
        structs_at<&ProxiesSpec::cutouts>({.name = "cutouts",
                                           .doc = "parts of the picture that stand upright where their foot is, and "
                                                  "face the camera: trees, poles, fences",
                                           .shape = "CutoutProxy"}),
        field_at<&ProxiesSpec::scene>(
            {.name = "scene",
             .doc = "what the scene's objects that stand still are. drawn: they are drawn into the picture; proxies: "
                    "the picture shows them already; hidden: they are not in it"})};
    return table;
}

FieldTable<IgnoredRegion> fields_of(std::type_identity<IgnoredRegion>) {
    static const std::vector<FieldOf<IgnoredRegion>> table{
        polygon_at<&IgnoredRegion::polygon_px>(
            {.name = "polygon_px", .doc = "its outline in the picture", .required = true, .unit = "px"}),
        field_at<&IgnoredRegion::object_class>(
            {.name = "object_class", .doc = "of what the picture shows there", .range = {1, 64}})};
    return table;
}

FieldTable<BackdropSpec> fields_of(std::type_identity<BackdropSpec>) {
    static const std::vector<FieldOf<BackdropSpec>> table{
        field_at<&BackdropSpec::kind>({.name = "kind", .doc = "plate: one picture of a camera that stands still"}),
        field_at<&BackdropSpec::file>(
            {.name = "file",
             .doc = "PNG or JPEG, upright, of the camera's size or of one with the same sides; relative to the scene "
                    "file, in its folder or below, or, of commands, an absolute path",
             .required = true}),
        field_at<&BackdropSpec::intrinsics>({.name = "intrinsics",
                                             .doc = "of the picture's own pixels, see intrinsics; they take the place "
                                                    "of the camera's, whatever its size",
                                             .unit = "px",
                                             .null = "the camera's are those of its size",
                                             .shape = "Intrinsics",
                                             .is_whole = true}),
        field_at<&BackdropSpec::proxies>({.name = "proxies",
                                          .doc = "shapes of what the picture shows: they hide what goes behind them",
                                          .shape = "Proxies",
                                          .is_whole = true}),
        structs_at<&BackdropSpec::ignore>(
            {.name = "ignore",
             .doc = "where the picture shows people or vehicles of its own, which truth does not know",
             .shape = "IgnoredRegion"})};
    return table;
}

}  // namespace camrig::world
