#include "core/world/scene_reader.h"

#include <array>
#include <cmath>
#include <set>

#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/world/camera_json.h"
#include "core/world/model_lights.h"
#include "core/world/route_path.h"
#include "core/world/scene_names.h"

namespace camrig {
namespace {

using nlohmann::json;

constexpr double max_speed_m_s = 1000.0;
constexpr double max_scale = 1e6;

std::string item(std::string_view list, std::size_t index) {
    return std::string(list) + "[" + std::to_string(index) + "]";
}

/// Names of scene things are free text that stays readable in messages and truth files.
bool good_name(std::string_view name) {
    bool good = !name.empty() && name.size() <= max_scene_name_bytes;
    for (const char c : name) good = good && static_cast<unsigned char>(c) >= 0x20 && c != 0x7f;
    return good;
}

void required_name(JsonReader& reader, std::string_view key, std::string& out) {
    reader.required(key, out);
    if (reader.ok() && !good_name(out)) reader.fail(key, "expected 1 to 64 printable characters");
}

void optional_in_range(JsonReader& reader, std::string_view key, double& out, double low, double high) {
    reader.optional(key, out);
    if (reader.ok() && !(out >= low && out <= high)) {
        reader.fail(key, "expected a number from " + json(low).dump() + " to " + json(high).dump());
    }
}

void optional_color(JsonReader& reader, std::string_view key, glm::vec3& out) {
    if (!reader.has(key)) return;
    std::array<double, 3> rgb{};
    reader.required(key, std::span<double>(rgb));
    for (const double part : rgb)
        if (reader.ok() && (part < 0.0 || part > 1e4)) reader.fail(key, "expected linear [r, g, b] from 0");
    out = {rgb[0], rgb[1], rgb[2]};
}

bool read_vector(JsonReader& reader, std::string_view key, glm::dvec3& out) {
    if (!reader.has(key)) return false;
    std::array<double, 3> v{};
    reader.required(key, std::span<double>(v));
    for (const double part : v) {
        if (reader.ok() && std::abs(part) > max_coordinate_m)
            reader.fail(key, "expected coordinates within 1e10 m of the origin");
    }
    out = {v[0], v[1], v[2]};
    return true;
}

/// "yaw_deg" (about z, counter-clockwise) or "orientation": [x, y, z, w].
bool read_orientation(JsonReader& reader, glm::dquat& out) {
    const bool quaternion = reader.has("orientation"), yaw = reader.has("yaw_deg");
    if (quaternion && yaw) reader.fail("yaw_deg", "give only one of yaw_deg and orientation");
    double yaw_deg = 0.0;
    reader.optional("yaw_deg", yaw_deg);
    if (yaw) out = glm::angleAxis(glm::radians(yaw_deg), glm::dvec3(0.0, 0.0, 1.0));
    reader.find("orientation");
    if (quaternion) {
        std::array<double, 4> q{};
        reader.required("orientation", std::span<double>(q));
        auto pose = pose_from_quaternion(glm::dvec3(0.0), glm::dquat(q[3], q[0], q[1], q[2]));
        if (pose)
            out = pose->orientation;
        else
            reader.fail("orientation", pose.error().message, pose.error().kind);
    }
    return quaternion || yaw;
}

Environment read_environment(const json& value, JsonReader& parent) {
    Environment environment;
    JsonReader reader(value, "environment");
    optional_color(reader, "background", environment.background);
    reader.find("background");
    if (const json* ambient = reader.find("ambient")) {
        JsonReader nested(*ambient, "environment.ambient");
        for (const char* key : {"sky", "ground"}) nested.find(key);
        optional_color(nested, "sky", environment.ambient_sky);
        optional_color(nested, "ground", environment.ambient_ground);
        if (auto done = nested.finish(); !done) reader.fail(done.error());
    }
    double exposure = 1.0;
    optional_in_range(reader, "exposure", exposure, 1e-6, 1e6);
    environment.exposure = static_cast<float>(exposure);
    if (auto done = reader.finish(); !done) parent.fail(done.error());
    return environment;
}

void read_direction(JsonReader& reader, glm::dvec3& out) {
    if (!read_vector(reader, "direction", out)) return reader.fail("direction", "is missing");
    const double length = glm::length(out);
    if (!(length > 1e-9)) return reader.fail("direction", "has no length");
    out /= length;
}

Result<Light> read_light(const json& value, std::string path) {
    JsonReader reader(value, std::move(path));
    for (const char* key : {"color", "position", "direction"}) reader.find(key);
    Light light;
    std::string type;
    required_name(reader, "name", light.name);
    reader.required("type", type);
    optional_color(reader, "color", light.color);
    double intensity = 1.0, range = 0.0, inner_deg = 0.0, outer_deg = 45.0;
    optional_in_range(reader, "intensity", intensity, 0.0, 1e9);
    const bool placed = type == "point" || type == "spot";
    if (type == "directional")
        light.type = LightType::directional;
    else if (type == "spot")
        light.type = LightType::spot;
    else if (type == "point")
        light.type = LightType::point;
    else if (reader.ok())
        reader.fail("type", "'" + type.substr(0, 40) + "' is none of directional, point, spot");
    if (placed) {
        if (!read_vector(reader, "position", light.position)) reader.fail("position", "is missing");
        optional_in_range(reader, "range", range, 0.0, 1e9);
    }
    if (light.type == LightType::spot) {
        optional_in_range(reader, "inner_cone_deg", inner_deg, 0.0, 90.0);
        optional_in_range(reader, "outer_cone_deg", outer_deg, 0.0, 90.0);
        if (reader.ok() && inner_deg >= outer_deg) reader.fail("outer_cone_deg", "must be over inner_cone_deg");
    }
    if (light.type != LightType::point) {
        read_direction(reader, light.direction);
    } else if (reader.has("direction")) {
        reader.fail("direction", "a point light has none");
    }
    if (light.type == LightType::directional && reader.has("position"))
        reader.fail("position", "a directional light has none");
    light.intensity = static_cast<float>(intensity);
    light.range = static_cast<float>(range);
    light.inner_cone_rad = static_cast<float>(glm::radians(inner_deg));
    light.outer_cone_rad = static_cast<float>(glm::radians(outer_deg));
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return light;
}

Result<Route> read_route(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    Route route;
    if (!reader.has("points")) reader.fail("points", "is missing");
    const auto points = reader.array("points", max_route_points);
    for (std::size_t i = 0; i < points.size() && reader.ok(); ++i) {
        const json& point = points[i];
        glm::dvec3 p(0.0);
        bool good = point.is_array() && (point.size() == 2 || point.size() == 3);
        for (std::size_t c = 0; good && c < point.size(); ++c) {
            good = point[c].is_number() && std::abs(point[c].get<double>()) <= max_coordinate_m;
            if (good) p[static_cast<glm::length_t>(c)] = point[c].get<double>();
        }
        if (!good) reader.fail(item("points", i), "expected [x, y] or [x, y, z] within 1e10 m");
        route.points.push_back(p);
    }
    reader.optional("closed", route.closed);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    if (auto walked = RoutePath::create(route); !walked) {
        walked.error().message.insert(0, path + ".");
        return std::unexpected(walked.error());
    }
    return route;
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
    } else if (reader.ok()) {
        reader.fail("pose", "is missing");
    }
    double vfov_deg = 60.0;
    optional_in_range(reader, "vfov_deg", vfov_deg, 0.01, 179.9);
    place.vfov_rad = glm::radians(vfov_deg);
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return place;
}

/// Turns the z-up model so that what is its front in glTF's frame looks along +x.
std::optional<glm::dquat> heading_from_front(std::string_view front) {
    const auto about_z = [](double deg) { return glm::angleAxis(glm::radians(deg), glm::dvec3(0.0, 0.0, 1.0)); };
    if (front == "+z") return about_z(90.0);  // glTF +z is -y in the z-up frame
    if (front == "-z") return about_z(-90.0);
    if (front == "+x") return glm::dquat(1.0, 0.0, 0.0, 0.0);
    if (front == "-x") return about_z(180.0);
    return std::nullopt;
}

/// Reads a scene file part by part; later parts refer to names of earlier ones.
class SceneReader {
public:
    SceneReader(const json& document, std::filesystem::path folder, const ModelSource& source)
        : reader_(document, ""), folder_(std::move(folder)), source_(source) {}
    Result<Scene> read();

private:
    void read_head();
    void read_models();
    void read_objects();
    void read_actors();
    void read_cameras();
    template <typename Value, typename Read>
    void read_map(std::string_view key, std::size_t limit, std::map<std::string, Value>& out, Read&& read);
    const SceneModel* read_model_name(JsonReader& reader, std::string& out) const;
    void check_clip(JsonReader& reader, const SceneModel* model, const std::string& clip) const;
    BehaviourSpec read_behaviour(const json& value, const std::string& path, const SceneModel* model,
                                 JsonReader& parent) const;
    void claim_name(JsonReader& reader, const std::string& name);

    JsonReader reader_;
    std::filesystem::path folder_;
    const ModelSource& source_;
    Scene scene_;
    std::set<std::string> names_;  ///< of objects and actors
};

void SceneReader::read_head() {
    int version = 0;
    reader_.required("camrig_scene", version);
    if (reader_.ok() && version != 1)
        reader_.fail("camrig_scene", "version " + std::to_string(version) + "; this program reads version 1",
                     ErrorKind::unsupported);
    required_name(reader_, "name", scene_.name);
    reader_.optional("description", scene_.description);
    reader_.optional("seed", scene_.seed);
    reader_.optional("step_ns", scene_.step_ns);
    if (reader_.ok() && (scene_.step_ns < min_step_ns || scene_.step_ns > max_step_ns))
        reader_.fail("step_ns", "expected 1000000 to 100000000 ns");
    if (const json* value = reader_.find("environment")) scene_.environment = read_environment(*value, reader_);
}

template <typename Value, typename Read>
void SceneReader::read_map(std::string_view key, std::size_t limit, std::map<std::string, Value>& out, Read&& read) {
    const json* entries = reader_.find(key);
    if (!entries) return;
    if (!entries->is_object()) return reader_.fail(key, "expected an object");
    if (entries->size() > limit)
        return reader_.fail(key, "more than " + std::to_string(limit) + " entries", ErrorKind::resource_exhausted);
    for (const auto& [name, value] : entries->items()) {
        if (!good_name(name)) return reader_.fail(key, "names are 1 to 64 printable characters");
        auto entry = read(value, std::string(key) + "." + name);
        if (!entry) return reader_.fail(entry.error());
        out.emplace(name, std::move(*entry));
    }
}

void SceneReader::read_models() {
    std::map<std::string, ModelRef> loaded;  // by file: two names of one file share the model
    read_map("models", max_scene_models, scene_.models,
             [&](const json& value, const std::string& path) -> Result<SceneModel> {
                 JsonReader reader(value, path);
                 std::string file, front = "+z";
                 reader.required("file", file);
                 reader.optional("front", front);
                 const auto heading = heading_from_front(front);
                 if (reader.ok() && !heading)
                     reader.fail("front", "'" + front.substr(0, 40) + "' is none of +x, -x, +z, -z");
                 const std::filesystem::path relative(file);
                 bool inside = relative.is_relative() && !file.empty() && file.find('\0') == std::string::npos;
                 for (const auto& part : relative) inside = inside && part != "..";
                 if (reader.ok() && !inside) reader.fail("file", "must be a path below the scene file's folder");
                 if (auto done = reader.finish(); !done) return std::unexpected(done.error());
                 ModelRef& model = loaded[file];
                 if (!model) {
                     auto result = source_(folder_ / relative);
                     if (!result) return at(path + ".file", result.error());
                     model = *result;
                 }
                 return SceneModel{model, *heading};
             });
}

void SceneReader::claim_name(JsonReader& reader, const std::string& name) {
    if (reader.ok() && !names_.insert(name).second)
        reader.fail("name", "'" + name + "' is taken by another object or actor", ErrorKind::already_exists);
}

const SceneModel* SceneReader::read_model_name(JsonReader& reader, std::string& out) const {
    reader.required("model", out);
    if (!reader.ok()) return nullptr;
    const auto found = scene_.models.find(out);
    if (found != scene_.models.end()) return &found->second;
    reader.fail("model", "no model '" + out.substr(0, 80) + "'; known: " + known_names(scene_.models),
                ErrorKind::not_found);
    return nullptr;
}

void SceneReader::check_clip(JsonReader& reader, const SceneModel* model, const std::string& clip) const {
    if (!reader.ok() || clip.empty() || model->model->find_animation(clip) >= 0) return;
    reader.fail("clip", "the model has no clip '" + clip.substr(0, 80) + "'; it has: " + known_clips(*model->model),
                ErrorKind::not_found);
}

void SceneReader::read_objects() {
    const auto items = reader_.array("objects", max_scene_objects);
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item("objects", i));
        for (const char* key : {"position", "orientation"}) reader.find(key);
        ObjectSpec object;
        required_name(reader, "name", object.name);
        claim_name(reader, object.name);
        const SceneModel* model = read_model_name(reader, object.model);
        if (reader.has("class")) required_name(reader, "class", object.object_class);
        read_vector(reader, "position", object.position);
        read_orientation(reader, object.orientation);
        optional_in_range(reader, "scale", object.scale, 1e-6, max_scale);
        reader.optional("clip", object.clip);
        check_clip(reader, model, object.clip);
        if (auto done = reader.finish(); !done) return reader_.fail(done.error());
        scene_.objects.push_back(std::move(object));
    }
}

BehaviourSpec SceneReader::read_behaviour(const json& value, const std::string& path, const SceneModel* model,
                                          JsonReader& parent) const {
    JsonReader reader(value, path);
    std::string type, clip;
    reader.required("type", type);
    reader.optional("clip", clip);
    check_clip(reader, model, clip);
    BehaviourSpec spec = StandBehaviour{clip};
    if (type == "route") {
        RouteBehaviour route;
        route.clip = clip;
        std::string mode;
        reader.required("route", route.route);
        const auto found = scene_.routes.find(route.route);
        if (reader.ok() && found == scene_.routes.end())
            reader.fail("route", "no route '" + route.route.substr(0, 80) + "'; known: " + known_names(scene_.routes),
                        ErrorKind::not_found);
        const bool closed = reader.ok() && found->second.closed;
        optional_in_range(reader, "speed", route.speed_m_s, 1e-3, max_speed_m_s);
        optional_in_range(reader, "start_m", route.start_m, 0.0, 1e9);
        mode = closed ? "loop" : "ping_pong";
        reader.optional("mode", mode);
        using Mode = RouteBehaviour::Mode;
        if (mode == "loop")
            route.mode = Mode::loop;
        else if (mode == "ping_pong")
            route.mode = Mode::ping_pong;
        else if (mode == "once")
            route.mode = Mode::once;
        else
            reader.fail("mode", "'" + mode.substr(0, 40) + "' is none of loop, ping_pong, once");
        if (reader.ok() && (route.mode == Mode::loop) != closed && route.mode != Mode::once)
            reader.fail("mode", closed ? "a closed route is walked in mode loop or once"
                                       : "an open route is walked in mode ping_pong or once");
        spec = std::move(route);
    } else if (type != "stand" && reader.ok()) {
        reader.fail("type", "'" + type.substr(0, 40) + "' is none of route, stand");
    }
    if (auto done = reader.finish(); !done) parent.fail(done.error());
    return spec;
}

void SceneReader::read_actors() {
    const auto items = reader_.array("actors", max_scene_actors);
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item("actors", i));
        for (const char* key : {"position", "orientation"}) reader.find(key);
        ActorSpec actor;
        required_name(reader, "name", actor.name);
        claim_name(reader, actor.name);
        const SceneModel* model = read_model_name(reader, actor.model);
        if (reader.has("class")) required_name(reader, "class", actor.object_class);
        bool placed = read_vector(reader, "position", actor.position);
        placed = read_orientation(reader, actor.orientation) || placed;
        optional_in_range(reader, "scale", actor.scale, 1e-6, max_scale);
        if (const json* behaviour = reader.find("behaviour"))
            actor.behaviour = read_behaviour(*behaviour, reader.path_of("behaviour"), model, reader);
        if (placed && std::holds_alternative<RouteBehaviour>(actor.behaviour))
            reader.fail("position", "its route places this actor; leave position and orientation out");
        if (auto done = reader.finish(); !done) return reader_.fail(done.error());
        scene_.actors.push_back(std::move(actor));
    }
}

void SceneReader::read_cameras() {
    const auto items = reader_.array("cameras", max_scene_cameras);
    std::set<std::string> names;
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item("cameras", i));
        CameraSpec spec;
        reader.required("name", spec.name);
        if (reader.ok())
            if (auto good = check_name(reader.path_of("name"), spec.name); !good) reader.fail(good.error());
        if (reader.ok() && !names.insert(spec.name).second)
            reader.fail("name", "'" + spec.name + "' is taken by another camera", ErrorKind::already_exists);
        std::optional<std::string> place;
        reader.optional("place", place);
        CameraPatch patch = read_camera_patch(reader);
        if (place && reader.ok()) {
            const auto found = scene_.places.find(*place);
            if (found == scene_.places.end()) {
                reader.fail("place", "no place '" + place->substr(0, 80) + "'; known: " + known_names(scene_.places),
                            ErrorKind::not_found);
            } else {
                if (!patch.pose) patch.pose = found->second.pose;
                if (!patch.optics) patch.optics = VerticalFov{found->second.vfov_rad};
            }
        }
        if (auto done = reader.finish(); !done) return reader_.fail(done.error());
        auto camera = patch_camera_spec(spec, patch);
        if (!camera) {
            camera.error().message.insert(0, item("cameras", i) + ".");
            return reader_.fail(camera.error());
        }
        scene_.cameras.push_back(std::move(*camera));
    }
}

Result<Scene> SceneReader::read() {
    read_head();
    read_models();
    read_map("routes", max_scene_routes, scene_.routes, read_route);
    read_map("places", max_scene_places, scene_.places, read_place);
    read_objects();
    const auto lights = reader_.array("lights", max_scene_lights);
    for (std::size_t i = 0; i < lights.size() && reader_.ok(); ++i) {
        if (auto light = read_light(lights[i], item("lights", i)))
            scene_.lights.push_back(std::move(*light));
        else
            reader_.fail(light.error());
    }
    read_actors();
    read_cameras();
    if (auto done = reader_.finish(); !done) return std::unexpected(done.error());
    for (const ObjectSpec& object : scene_.objects)
        append_model_lights(*scene_.models.at(object.model).model, object, scene_.lights);
    if (scene_.lights.size() > max_scene_lights)
        return error(ErrorKind::resource_exhausted,
                     "lights: more than " + std::to_string(max_scene_lights) + " with those of the models");
    return std::move(scene_);
}

}  // namespace

Result<Scene> read_scene(const json& document, const std::filesystem::path& folder, const ModelSource& models) {
    return SceneReader(document, folder, models).read();
}

}  // namespace camrig
