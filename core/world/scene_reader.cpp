#include "core/world/scene_reader.h"

#include <set>

#include "core/base/error_list.h"
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
#include "core/world/read/model_json.h"
#include "core/world/scene_names.h"
#include "core/world/turn.h"

namespace camrig {
namespace {

using nlohmann::json;

constexpr double max_object_scale = 1e6;

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
    bool spoil(const std::string& path, const std::string& name, const Error& why);
    bool spoil(std::string_view list, std::size_t index, const json& item, const Error& why);
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
    if (reader_.ok("camrig_scene") && version != 1)
        reader_.fail("camrig_scene", "version " + std::to_string(version) + "; this program reads version 1",
                     ErrorKind::unsupported);
    required_name(reader_, "name", scene_.name);
    reader_.optional("description", scene_.description);
    reader_.optional("seed", scene_.seed);
    reader_.optional("step_ns", scene_.step_ns);
    if (reader_.ok("step_ns") && (scene_.step_ns < min_step_ns || scene_.step_ns > max_step_ns))
        reader_.fail("step_ns", "expected 1000000 to 100000000 ns");
    if (const json* value = reader_.find("environment")) {
        auto environment = read_environment(*value, "environment");
        if (environment)
            scene_.environment = *environment;
        else
            reader_.fail(environment.error());
    }
}

/// Remembers why a part was not read, and what it is called. Whether to read on: with an ErrorList.
bool SceneReader::spoil(const std::string& path, const std::string& name, const Error& why) {
    ErrorList* const list = ErrorList::current();
    if (list) {
        list->add(path, why);
        list->excuse(name);
    }
    reader_.fail(why);
    return list != nullptr;
}

bool SceneReader::spoil(std::string_view list, std::size_t index, const json& item, const Error& why) {
    const bool is_named = item.is_object() && item.contains("name") && item["name"].is_string();
    return spoil(item_path(list, index), is_named ? item["name"].get<std::string>() : "", why);
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
        const std::string path = std::string(key) + "." + name;
        auto entry = read(value, path);
        if (entry)
            out.emplace(name, std::move(*entry));
        else if (!spoil(path, name, entry.error()))
            return;
    }
}

void SceneReader::read_models() {
    ModelReader models(folder_, source_);
    read_map("models", max_scene_models, scene_.models,
             [&](const json& value, const std::string& path) { return models.read(value, path); });
}

void SceneReader::claim_name(JsonReader& reader, const std::string& name) {
    if (reader.ok() && !names_.insert(name).second)
        reader.fail("name", "'" + name + "' is taken by another object or actor", ErrorKind::already_exists);
}

const SceneModel* SceneReader::read_model_name(JsonReader& reader, std::string& out) const {
    reader.required("model", out);
    if (!reader.ok("model")) return nullptr;
    const auto found = scene_.models.find(out);
    if (found != scene_.models.end()) return &found->second;
    if (const ErrorList* const list = ErrorList::current(); list && list->excuses(out)) return nullptr;
    reader.fail("model", "no model '" + out.substr(0, 80) + "'; known: " + known_names(scene_.models),
                ErrorKind::not_found);
    return nullptr;
}

void SceneReader::read_objects() {
    const auto items = reader_.array("objects", max_scene_objects);
    for (std::size_t i = 0; i < items.size(); ++i) {
        JsonReader reader(items[i], item_path("objects", i));
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
        if (reader.ok("clip") && model)
            if (auto good = check_clip(*model->model, object.clip, reader.path_of("clip")); !good)
                reader.fail(good.error());
        if (auto done = reader.finish(); done)
            scene_.objects.push_back(std::move(object));
        else if (!spoil("objects", i, items[i], done.error()))
            return;
    }
}

void SceneReader::read_actors() {
    const auto items = reader_.array("actors", max_scene_actors);
    for (std::size_t i = 0; i < items.size(); ++i) {
        JsonReader reader(items[i], item_path("actors", i));
        auto actor = read_actor(reader);
        if (actor) claim_name(reader, actor->name);
        if (auto done = reader.finish(); done)
            scene_.actors.push_back(std::move(*actor));
        else if (!spoil("actors", i, items[i], done.error()))
            return;
    }
}

void SceneReader::read_events() {
    const auto items = reader_.array("events", max_scene_events);
    std::set<std::string> names;
    for (std::size_t i = 0; i < items.size(); ++i) {
        JsonReader reader(items[i], item_path("events", i));
        auto event = read_event(reader);
        if (event && !names.insert(event->name).second)
            reader.fail("name", "'" + event->name + "' is taken by another event", ErrorKind::already_exists);
        if (auto done = reader.finish(); done)
            scene_.events.push_back(std::move(*event));
        else if (!spoil("events", i, items[i], done.error()))
            return;
    }
}

/// What one part says of others, when all are read.
void SceneReader::check_references() {
    if (!reader_.ok() && !ErrorList::current()) return;
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
    for (std::size_t i = 0; i < items.size(); ++i) {
        JsonReader reader(items[i], item_path("cameras", i));
        CameraSpec spec;
        reader.required("name", spec.name);
        if (reader.ok("name"))
            if (auto good = check_name(reader.path_of("name"), spec.name); !good) reader.fail(good.error());
        if (reader.ok("name") && !names.insert(spec.name).second)
            reader.fail("name", "'" + spec.name + "' is taken by another camera", ErrorKind::already_exists);
        std::optional<std::string> place;
        reader.optional("place", place);
        CameraPatch patch = read_camera_patch(reader);
        if (place) {
            const auto found = scene_.places.find(*place);
            const ErrorList* const list = ErrorList::current();
            if (found == scene_.places.end() && !(list && list->excuses(*place))) {
                reader.fail("place", "no place '" + place->substr(0, 80) + "'; known: " + known_names(scene_.places),
                            ErrorKind::not_found);
            } else if (found != scene_.places.end()) {
                if (!patch.pose) patch.pose = found->second.pose;
                if (!patch.optics) patch.optics = VerticalFov{found->second.vfov_rad};
            }
        }
        auto camera = reader.ok() ? patch_camera_spec(spec, patch) : Result<CameraSpec>(CameraSpec{});
        if (!camera) reader.fail_inside(camera.error());
        if (auto done = reader.finish(); done)
            scene_.cameras.push_back(std::move(*camera));
        else if (!spoil("cameras", i, items[i], done.error()))
            return;
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
    for (std::size_t i = 0; i < lights.size(); ++i) {
        if (auto light = read_light(lights[i], item_path("lights", i)))
            scene_.lights.push_back(std::move(*light));
        else if (!spoil("lights", i, lights[i], light.error()))
            break;
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
