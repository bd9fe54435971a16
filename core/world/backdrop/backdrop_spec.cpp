#include "core/world/backdrop/backdrop_spec.h"

#include "core/base/picture_fields.h"
#include "core/camera/pose.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/backdrop/film_player.h"
#include "core/world/camera_fields.h"
#include "core/world/camera_json.h"
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

/// An entry that null takes away.
FieldOf<BackdropSpec> or_null(FieldOf<BackdropSpec> entry) {
    entry.read = [read = entry.read, name = entry.field.name](JsonReader& reader, Changes<BackdropSpec>& changes) {
        if (!reader.has_null(name)) read(reader, changes);
    };
    return entry;
}

FieldOf<BackdropSpec> rate_of_film() {
    auto entry = entry_by<&BackdropSpec::fps>(
        {.name = "fps",
         .type = "number or \"num/den\" or null",
         .doc = "of a film: how many of its pictures are shown in a second, 1/10 to 1000",
         .unit = "1/s",
         .fallback = "null",
         .null = "as the film says",
         .schema = R"({"anyOf": [{"type": "number"}, {"type": "string"}, {"type": "null"}]})"},
        [](JsonReader& reader, std::string_view key, Rate& out) {
            if (const auto rate = camrig::read_rate(reader, key)) out = *rate;
        });
    entry = or_null(std::move(entry));
    entry.write = [](const BackdropSpec& spec) { return spec.fps ? rate_to_json(*spec.fps) : json(nullptr); };
    return entry;
}

/// What was read of `file`; taken, so that the answer of camera.get makes a camera, and unused.
FieldOf<BackdropSpec> picture_size() {
    FieldOf<BackdropSpec> entry{
        .field = {.name = "picture_size",
                  .type = "[width, height]",
                  .doc = "of the picture: that of all pixels here; 0 of a panorama",
                  .unit = "px",
                  .by = Field::By::rig,
                  .schema = R"({"type": "array", "items": {"type": "number"}, "minItems": 2, "maxItems": 2})"}};
    entry.read = [](JsonReader& reader, Changes<BackdropSpec>&) {
        std::array<double, 2> unused{};
        if (reader.find("picture_size")) reader.required("picture_size", std::span<double>(unused));
    };
    entry.write = [](const BackdropSpec& spec) {
        const ImageSize size = spec.files == nullptr ? ImageSize{} : spec.files->size();
        return json{size.width, size.height};
    };
    return entry;
}

FieldOf<BackdropSpec> taken_from() {
    auto entry = or_null(
        nested_at<&BackdropSpec::taken_from>({.name = "taken_from",
                                              .type = "object or null",
                                              .doc = "of a projected picture: the pose of its camera, see pose",
                                              .fallback = "null",
                                              .null = "the kind is another one",
                                              .parts = pose_fields(),
                                              .shape = "Pose",
                                              .is_whole = true,
                                              .schema = R"({"anyOf": [{"$ref": "#/$defs/pose"}, {"type": "null"}]})"},
                                             read_pose));
    entry.write = [](const BackdropSpec& spec) {
        return spec.taken_from ? pose_to_json(*spec.taken_from) : json(nullptr);
    };
    return entry;
}

FieldOf<BackdropSpec> lens_of_picture() {
    auto entry = or_null(
        nested_at<&BackdropSpec::lens>({.name = "lens",
                                        .type = "object or null",
                                        .doc = "of a projected picture: that of the camera that took it, see lens",
                                        .fallback = "null",
                                        .null = "the camera's own",
                                        .parts = lens_model_fields(),
                                        .shape = "PictureLens",
                                        .is_whole = true},
                                       read_lens_model));
    entry.write = [](const BackdropSpec& spec) { return spec.lens ? lens_to_json(*spec.lens) : json(nullptr); };
    return entry;
}

template <typename T>
auto ground_polygon_m() {
    return polygon_at<&T::polygon_m>({.name = "polygon_m", .doc = "its corners in the world", .unit = "m"});
}
template <typename T>
auto ground_polygon_px() {
    return polygon_at<&T::polygon_px>(
        {.name = "polygon_px", .doc = "instead: its corners in the picture, below the horizon", .unit = "px"});
}

template <typename T>
auto role_of_shape() {
    return field_at<&T::role>({.name = "role",
                               .doc = "both: it hides who goes behind it, and shadows fall on it; catcher: only "
                                      "shadows fall on it; holdout: it only hides"});
}

template <typename T>
auto ground_height() {
    return field_at<&T::z>({.name = "z", .doc = "height of the ground", .unit = "m", .range = {-most_m, most_m}});
}

}  // namespace

std::span<const Named<BackdropKind>> names_of(std::type_identity<BackdropKind>) {
    static constexpr Named<BackdropKind> names[] = {{BackdropKind::plate, "plate"},
                                                    {BackdropKind::film, "film"},
                                                    {BackdropKind::panorama, "panorama"},
                                                    {BackdropKind::projected, "projected"}};
    return names;
}

std::span<const Named<ProxyRole>> names_of(std::type_identity<ProxyRole>) {
    static constexpr Named<ProxyRole> names[] = {
        {ProxyRole::both, "both"}, {ProxyRole::catcher, "catcher"}, {ProxyRole::holdout, "holdout"}};
    return names;
}

std::span<const Named<SceneInBackdrop>> names_of(std::type_identity<SceneInBackdrop>) {
    static constexpr Named<SceneInBackdrop> names[] = {
        {SceneInBackdrop::drawn, "drawn"}, {SceneInBackdrop::proxies, "proxies"}, {SceneInBackdrop::hidden, "hidden"}};
    return names;
}

std::span<const Named<BackdropShadow>> names_of(std::type_identity<BackdropShadow>) {
    static constexpr Named<BackdropShadow> names[] = {
        {BackdropShadow::none, "none"}, {BackdropShadow::blob, "blob"}, {BackdropShadow::mapped, "mapped"}};
    return names;
}

FieldTable<PlateNoise> fields_of(std::type_identity<PlateNoise>) {
    static const std::vector<FieldOf<PlateNoise>> table{
        field_at<&PlateNoise::k>({.name = "k", .doc = "how its variance grows with the level", .range = {0, 10}}),
        field_at<&PlateNoise::read>(
            {.name = "read", .doc = "standard deviation at level 0, in codes of 255", .range = {0, 50}})};
    return table;
}

FieldTable<LevelGround> fields_of(std::type_identity<LevelGround>) {
    static const std::vector<FieldOf<LevelGround>> table{
        ground_polygon_m<LevelGround>(), ground_polygon_px<LevelGround>(), ground_height<LevelGround>()};
    return table;
}

FieldTable<GroundProxy> fields_of(std::type_identity<GroundProxy>) {
    static const std::vector<FieldOf<GroundProxy>> table{ground_polygon_m<GroundProxy>(),
                                                         ground_polygon_px<GroundProxy>(), ground_height<GroundProxy>(),
                                                         role_of_shape<GroundProxy>()};
    return table;
}

FieldTable<BoxProxy> fields_of(std::type_identity<BoxProxy>) {
    static const std::vector<FieldOf<BoxProxy>> table{
        numbers_at<&BoxProxy::position>(
            {.name = "position", .doc = "the middle of its bottom", .required = true, .unit = "m"}, -most_m, most_m),
        numbers_at<&BoxProxy::size>({.name = "size", .doc = "along its x, y and z", .required = true, .unit = "m"},
                                    least_box_m, most_box_m),
        field_at<&BoxProxy::yaw_deg>(
            {.name = "yaw_deg", .doc = "about z, counter-clockwise", .unit = "deg", .range = {-360, 360}}),
        role_of_shape<BoxProxy>()};
    return table;
}

FieldTable<CutoutProxy> fields_of(std::type_identity<CutoutProxy>) {
    static const std::vector<FieldOf<CutoutProxy>> table{
        polygon_at<&CutoutProxy::polygon_px>({.name = "polygon_px", .doc = "its outline in the picture", .unit = "px"}),
        field_at<&CutoutProxy::mask>(
            {.name = "mask",
             .doc = "instead: PNG of the picture's size, beside it; what is opaque or, if all of it is, light is cut "
                    "out. Empty: none"}),
        numbers_at<&CutoutProxy::foot_px>({.name = "foot_px",
                                           .doc = "where it stands on the ground, below the horizon",
                                           .required = true,
                                           .unit = "px"},
                                          -1e6, 1e6),
        ground_height<CutoutProxy>(), role_of_shape<CutoutProxy>()};
    return table;
}

std::span<const Named<DepthMeasure>> names_of(std::type_identity<DepthMeasure>) {
    static constexpr Named<DepthMeasure> names[] = {{DepthMeasure::z, "z"}, {DepthMeasure::range, "range"}};
    return names;
}

FieldTable<DepthProxy> fields_of(std::type_identity<DepthProxy>) {
    static const std::vector<FieldOf<DepthProxy>> table{
        field_at<&DepthProxy::file>({.name = "file",
                                     .doc = "PNG of 16-bit gray of the picture's size, beside it; 0 where nothing is "
                                            "known or there",
                                     .required = true}),
        field_at<&DepthProxy::unit_m>({.name = "unit_m", .doc = "of its numbers", .unit = "m", .range = {1e-6, 1e3}}),
        field_at<&DepthProxy::measure>(
            {.name = "measure", .doc = "what they tell. z: along the camera's axis; range: from its eye"}),
        role_of_shape<DepthProxy>()};
    return table;
}

FieldTable<ProxiesSpec> fields_of(std::type_identity<ProxiesSpec>) {
    static const std::vector<FieldOf<ProxiesSpec>> table{
        field_at<&ProxiesSpec::file>(
            {.name = "file",
             .doc = ".glb or .gltf, placed in the world as it is; beside `file` of the picture. Its nodes may say by "
                    "extras.camrig_proxy what they are: ground, obstacle, wall, catcher, holdout or walkable. Empty: "
                    "none"}),
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
        field_at<&ProxiesSpec::depth>({.name = "depth",
                                       .doc = "how far away each pixel of the picture is",
                                       .null = "not known",
                                       .shape = "DepthProxy",
                                       .is_whole = true}),
        structs_at<&ProxiesSpec::walkable>(
            {.name = "walkable",
             .doc =
                 "pieces of level ground where people may go, as ground is given; routes and areas of the scene file "
                 "that leave those of all cameras are errors. Empty: anywhere",
             .shape = "WalkableGround"}),
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
        field_at<&BackdropSpec::kind>(
            {.name = "kind",
             .doc = "plate: one picture of a camera that stands still; film: a film of "
                    "one, which is shown in step with world time, over and over; panorama: "
                    "equirectangular, what is all around a camera that may turn and zoom; projected: one "
                    "picture, laid on the proxies from where it was taken, for a camera "
                    "that moves a little"}),
        field_at<&BackdropSpec::file>(
            {.name = "file",
             .doc = "PNG or JPEG, or a film (MP4, Matroska, WebM, AVI, MPEG-TS, MJPEG), upright, of the camera's size "
                    "or of one with the same sides, a panorama of any size twice as wide as high, a projected "
                    "picture of any size; relative to the scene file, in its folder or below, or, of "
                    "commands, an absolute path",
             .required = true}),
        picture_size(),
        rate_of_film(),
        field_at<&BackdropSpec::yaw_deg>({.name = "yaw_deg",
                                          .doc = "of a panorama: which way its middle looks, about z, "
                                                 "counter-clockwise from +x",
                                          .unit = "deg",
                                          .range = {-360, 360}}),
        structs_at<&BackdropSpec::details>({.name = "details",
                                            .doc = "of a panorama: parts of it in finer pixels, for long lenses",
                                            .shape = "PanoramaDetail"}),
        field_at<&BackdropSpec::intrinsics>({.name = "intrinsics",
                                             .doc = "of the picture's own pixels, see intrinsics; they take the place "
                                                    "of the camera's, whatever its size (of a projected picture "
                                                    "they are needed, and the camera has its own)",
                                             .unit = "px",
                                             .null = "the camera's are those of its size",
                                             .shape = "Intrinsics",
                                             .is_whole = true}),
        taken_from(),
        lens_of_picture(),
        field_at<&BackdropSpec::proxies>({.name = "proxies",
                                          .doc = "shapes of what the picture shows: they hide what goes behind them",
                                          .shape = "Proxies",
                                          .is_whole = true}),
        field_at<&BackdropSpec::shadow>(
            {.name = "shadow",
             .doc = "of what moves, on what the picture shows. none; blob: about feet; mapped: of the scene's lights "
                    "at quality beautiful, at simple as blob"}),
        numbers_at<&BackdropSpec::plate_gain>(
            {.name = "plate_gain",
             .doc = "factors on the light of what is drawn, red, green and blue, so that white is that of the picture",
             .fallback = "[1, 1, 1]"},
            0.0, 100.0),
        field_at<&BackdropSpec::edge_px>(
            {.name = "edge_px",
             .doc = "what is drawn is made as soft as the picture: standard deviation of a Gaussian",
             .unit = "px",
             .range = {0, 3}}),
        field_at<&BackdropSpec::noise>({.name = "noise",
                                        .doc = "noise on what is drawn, as that of the picture: its standard deviation "
                                               "at a level of 0 to 255 is sqrt(read^2 + k * level)",
                                        .null = "none",
                                        .shape = "PlateNoise",
                                        .is_whole = true}),
        structs_at<&BackdropSpec::ignore>(
            {.name = "ignore",
             .doc = "where the picture shows people or vehicles of its own, which truth does not know",
             .shape = "IgnoredRegion"})};
    return table;
}

}  // namespace camrig::world
