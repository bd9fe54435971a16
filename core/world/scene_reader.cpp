#include "core/world/scene_reader.h"

#include <set>

#include "core/base/json_reader.h"
#include "core/base/names.h"
#include "core/world/camera_json.h"
#include "core/world/model_lights.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/check_names.h"
#include "core/world/read/event_json.h"
#include "core/world/read/ground_json.h"
#include "core/world/read/json_parts.h"
#include "core/world/read/light_json.h"
#include "core/world/scene_names.h"
#include "core/world/turn.h"

namespace camrig {
namespace {

using nlohmann::json;

constexpr double max_object_scale = 1e6;

/// Turns the z-up model so that what is its front in glTF's frame looks along +x.
std::optional<glm::dquat> heading_from_front(std::string_view front) {
    const auto about_z = [](double deg) { return turned_to(glm::radians(deg)); };
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
    void read_events();
    void check_references();
    template <typename Value, typename Read>
    void read_map(std::string_view key, std::size_t limit, std::map<std::string, Value>& out, Read&& read);
    const SceneModel* read_model_name(JsonReader& reader, std::string& out) const;
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
    if (const json* value = reader_.find("environment")) {
        auto environment = read_environment(*value, "environment");
        if (environment)
            scene_.environment = *environment;
        else
            reader_.fail(environment.error());
    }
}

template <typename Value, typename Read>
void SceneReader::read_map(std::string_view key, std::size_t limit, std::map<std::string, Value>& out, Read&& read) {
    const json* entries = reader_.find(key);
    if (!entries) return;
    if (!entries->is_object()) return reader_.fail(key, "expected an object");
    if (entries->size() > limit)
        return reader_.fail(key, "more than " + std::to_string(limit) + " entries", ErrorKind::resource_exhausted);
    for (const auto& [name, value] : entries->items()) {
        if (!is_scene_name(name)) return reader_.fail(key, "names are 1 to 64 printable characters");
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

void SceneReader::read_objects() {
    const auto items = reader_.array("objects", max_scene_objects);
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item_path("objects", i));
        for (const char* key : {"position", "orientation"}) reader.find(key);
        ObjectSpec object;
        required_name(reader, "name", object.name);
        claim_name(reader, object.name);
        const SceneModel* model = read_model_name(reader, object.model);
        optional_name(reader, "class", object.object_class);
        read_vector(reader, "position", object.position);
        read_orientation(reader, object.orientation);
        optional_in_range(reader, "scale", object.scale, 1e-6, max_object_scale);
        reader.optional("clip", object.clip);
        read_attachment(reader, "attach", object.attach);
        if (reader.ok() && model)
            if (auto good = check_clip(*model->model, object.clip, reader.path_of("clip")); !good)
                reader.fail(good.error());
        if (auto done = reader.finish(); !done) return reader_.fail(done.error());
        scene_.objects.push_back(std::move(object));
    }
}

void SceneReader::read_actors() {
    const auto items = reader_.array("actors", max_scene_actors);
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item_path("actors", i));
        auto actor = read_actor(reader);
        if (actor) claim_name(reader, actor->name);
        if (!actor) return reader_.fail(actor.error());
        if (auto done = reader.finish(); !done) return reader_.fail(done.error());
        scene_.actors.push_back(std::move(*actor));
    }
}

void SceneReader::read_events() {
    const auto items = reader_.array("events", max_scene_events);
    std::set<std::string> names;
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item_path("events", i));
        auto event = read_event(reader);
        if (!event) return reader_.fail(event.error());
        if (!names.insert(event->name).second)
            return reader_.fail(Error{ErrorKind::already_exists,
                                      reader.path_of("name") + ": '" + event->name + "' is taken by another event"});
        scene_.events.push_back(std::move(*event));
    }
}

/// What one part says of others, when all are read.
void SceneReader::check_references() {
    if (!reader_.ok()) return;
    const auto check = [this](Result<void> good) {
        if (!good) reader_.fail(good.error());
    };
    const KnownNames names = names_of(scene_);
    for (std::size_t i = 0; i < scene_.objects.size(); ++i) {
        const ObjectSpec& object = scene_.objects[i];
        if (object.attach) check(check_attachment(*object.attach, names, item_path("objects", i) + ".attach"));
    }
    for (std::size_t i = 0; i < scene_.cameras.size(); ++i)
        if (scene_.cameras[i].mount)
            check(check_mount(*scene_.cameras[i].mount, names, item_path("cameras", i) + ".mount"));
    FollowGraph follows;
    for (const ActorSpec& actor : scene_.actors) add_follows(actor.name, actor.behaviour, follows);
    std::set<std::string> carried, carriers;
    for (std::size_t i = 0; i < scene_.actors.size(); ++i) {
        const ActorSpec& actor = scene_.actors[i];
        const std::string path = item_path("actors", i);
        check(check_actor(actor, names, path));
        check(check_follows(actor.name, follows, path));
        if (!actor.attach) continue;
        carried.insert(actor.name);
        carriers.insert(actor.attach->actor);
    }
    for (const ObjectSpec& object : scene_.objects)
        if (object.attach) carriers.insert(object.attach->actor);
    for (const std::string& name : carriers)
        if (carried.contains(name))
            reader_.fail("actors", "'" + name + "' carries something and hangs on another; only one of both");
    for (std::size_t i = 0; i < scene_.events.size(); ++i) {
        check(check_event(scene_.events[i], names, item_path("events", i)));
        check(check_event_loop(scene_.events[i], scene_.events, item_path("events", i)));
    }
}

void SceneReader::read_cameras() {
    const auto items = reader_.array("cameras", max_scene_cameras);
    std::set<std::string> names;
    for (std::size_t i = 0; i < items.size() && reader_.ok(); ++i) {
        JsonReader reader(items[i], item_path("cameras", i));
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
            camera.error().message.insert(0, item_path("cameras", i) + ".");
            return reader_.fail(camera.error());
        }
        scene_.cameras.push_back(std::move(*camera));
    }
}

Result<Scene> SceneReader::read() {
    read_head();
    read_models();
    read_map("routes", max_scene_routes, scene_.routes, read_route);
    read_map("areas", max_scene_areas, scene_.areas, read_area);
    read_map("places", max_scene_places, scene_.places, read_place);
    read_objects();
    const auto lights = reader_.array("lights", max_scene_lights);
    for (std::size_t i = 0; i < lights.size() && reader_.ok(); ++i) {
        if (auto light = read_light(lights[i], item_path("lights", i)))
            scene_.lights.push_back(std::move(*light));
        else
            reader_.fail(light.error());
    }
    read_actors();
    read_cameras();
    read_events();
    check_references();
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
