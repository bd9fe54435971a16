#include "core/world/scene_reader.h"

#include <algorithm>
#include <set>

#include "core/base/error_list.h"
#include "core/base/names.h"
#include "core/world/backdrop/backdrop.h"
#include "core/world/camera_json.h"
#include "core/world/daylit.h"
#include "core/world/model_lights.h"
#include "core/world/photometric.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/check_names.h"
#include "core/world/read/check_walkable.h"
#include "core/world/read/event_json.h"
#include "core/world/read/ground_json.h"
#include "core/world/read/light_json.h"
#include "core/world/scene_names.h"
#include "core/world/world_fields.h"

namespace camrig::world {
namespace {

using nlohmann::json;

/// Names that no two of a list, or of several, may have.
struct UniqueNames {
    const char* owner;
    std::set<std::string> taken = {};

    /// The name of what the reader reads, before anything else of it: also of what turns out to be wrong.
    void claim(JsonReader& reader) {
        const json* const given = reader.find("name");
        const std::string name = given && given->is_string() ? given->get<std::string>() : "";
        if (is_scene_name(name) && !taken.insert(name).second)
            reader.fail("name", "'" + name + "' is taken by another " + owner, ErrorKind::already_exists);
    }
};

/// Reads a scene file part by part; later parts refer to names of earlier ones.
class SceneReader {
public:
    SceneReader(const json& document, std::filesystem::path folder, const ModelSource& source)
        : reader_(document, ""), folder_(std::move(folder)), source_(source) {}
    Result<Scene> read();

private:
    void read_parts();
    void check_references();
    void check_events(const KnownNames& names);
    void add_model_lights();
    void check_daylight();
    void check_groups();
    void light_by_day();
    void check_units();
    void use_units();
    bool spoil(const std::string& path, const std::string& name, const Error& why);
    template <typename Value, typename Read>
    void read_map(std::string_view key, std::size_t limit, std::map<std::string, Value>& out, Read&& read);
    template <typename Value, typename Read>
    void read_list(std::string_view key, std::size_t limit, std::vector<Value>& out, UniqueNames* names, Read&& read);
    void check_model_name(JsonReader& reader) const;
    Result<CameraSpec> read_camera(JsonReader& reader) const;

    JsonReader reader_;
    std::filesystem::path folder_;
    const ModelSource& source_;
    Scene scene_;
    std::vector<const char*> lights_in_units_;  ///< by light: the key of its unit; null: it has an intensity
};

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

template <typename Value, typename Read>
void SceneReader::read_list(std::string_view key, std::size_t limit, std::vector<Value>& out, UniqueNames* names,
                            Read&& read) {
    const auto items = reader_.array(key, limit);
    for (std::size_t i = 0; i < items.size(); ++i) {
        JsonReader reader(items[i], item_path(key, i));
        if (names) names->claim(reader);
        auto item = read(reader);
        const bool is_named = items[i].is_object() && items[i].contains("name") && items[i]["name"].is_string();
        if (item)
            out.push_back(std::move(*item));
        else if (!spoil(reader.path(), is_named ? items[i]["name"].get<std::string>() : "", item.error()))
            return;
    }
}

/// Whether the model is there of which an object or actor speaks, whatever else is wrong with it.
void SceneReader::check_model_name(JsonReader& reader) const {
    const json* const model = reader.find("model");
    if (!model || !model->is_string()) return;
    const auto name = model->get<std::string>();
    const ErrorList* const list = ErrorList::current();
    if (!scene_.models.contains(name) && !(list && list->excuses(name)))
        reader.fail("model", "no model '" + name.substr(0, 80) + "'; known: " + known_names(scene_.models),
                    ErrorKind::not_found);
}

/// What one part says of others, when all are read.
void SceneReader::check_references() {
    if (!reader_.ok() && !ErrorList::current()) return;
    const auto check = [this](Result<void> good) {
        if (!good) reader_.fail(good.error());
    };
    const KnownNames names = names_of(scene_);
    for (std::size_t i = 0; i < scene_.objects.size(); ++i)
        check(check_object(scene_.objects[i], names, item_path("objects", i)));
    for (std::size_t i = 0; i < scene_.cameras.size(); ++i)
        if (scene_.cameras[i].mount)
            check(check_mount(*scene_.cameras[i].mount, names, item_path("cameras", i) + ".mount"));
    FollowGraph follows;
    for (const ActorSpec& actor : scene_.actors) follows.add(actor.name, actor.behaviour);
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
    check_events(names);
    if (auto wrong = find_unwalkable(scene_)) reader_.fail(std::move(*wrong));
}

/// They name lights of models too, which are here while that is checked: to stay they come in the scene's units.
void SceneReader::check_events(const KnownNames& names) {
    if (scene_.events.empty()) return;
    const std::size_t own_lights = scene_.lights.size();
    add_model_lights();
    for (std::size_t i = 0; i < scene_.events.size(); ++i) {
        const std::string path = item_path("events", i);
        if (auto good = check_event(scene_.events[i], names, path); !good) reader_.fail(good.error());
        if (auto good = check_event_loop(scene_.events[i], scene_.events, path); !good) reader_.fail(good.error());
    }
    scene_.lights.resize(own_lights);
}

void SceneReader::add_model_lights() {
    ErrorList* const list = ErrorList::current();
    for (const ObjectSpec& object : scene_.objects) {
        const auto model = scene_.models.find(object.model);
        if (model != scene_.models.end())
            append_model_lights(*model->second.model, object, scene_.lights);
        else if (list)
            list->excuse(object.name);  // nobody knows which lights it has
        if (scene_.lights.size() > max_scene_lights) return;
    }
}

Result<CameraSpec> SceneReader::read_camera(JsonReader& reader) const {
    CameraSpec spec;
    reader.required("name", spec.name);
    if (reader.ok("name"))
        if (auto good = check_name(reader.path_of("name"), spec.name); !good) reader.fail(good.error());
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
    if (reader.ok())
        if (auto loaded = load_backdrop(patch, folder_); !loaded) reader.fail_inside(loaded.error());
    auto camera = reader.ok() ? patch_camera_spec(spec, patch) : Result<CameraSpec>(CameraSpec{});
    if (!camera) reader.fail_inside(camera.error());
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return camera;
}

void SceneReader::read_parts() {
    Changes<Scene> head;
    read_fields(fields_of(std::type_identity<Scene>{}), reader_, head);
    head.apply_to(scene_);
    ModelReader models(folder_, source_);
    read_map("models", max_scene_models, scene_.models,
             [&](const json& value, const std::string& path) { return models.read(value, path); });
    read_map("routes", max_scene_routes, scene_.routes, read_route);
    read_map("areas", max_scene_areas, scene_.areas, read_area);
    read_map("places", max_scene_places, scene_.places,
             [](const json& value, const std::string& path) { return read_all<Place>(value, path); });
    UniqueNames things{"object or actor"}, cameras{"camera"}, events{"event"};
    read_list("objects", max_scene_objects, scene_.objects, &things, [this](JsonReader& reader) {
        check_model_name(reader);
        return read_all<ObjectSpec>(reader);
    });
    read_list("lights", max_scene_lights, scene_.lights, nullptr, [this](JsonReader& reader) {
        auto light = read_whole_kind(light_kinds(), reader, "type");
        if (!light) return light;
        const char* const unit = light->type == LightType::directional ? "lux" : "candela";
        lights_in_units_.push_back(reader.has(unit) ? unit : nullptr);
        return light;
    });
    read_list("actors", max_scene_actors, scene_.actors, &things, [this](JsonReader& reader) {
        check_model_name(reader);
        return read_actor(reader);
    });
    read_list("cameras", max_scene_cameras, scene_.cameras, &cameras,
              [this](JsonReader& reader) { return read_camera(reader); });
    read_list("events", max_scene_events, scene_.events, &events, read_event);
}

/// What is in candela, lux and candela per square metre needs to know how many lux are white.
void SceneReader::check_units() {
    if (unit_lux(scene_.environment)) return;
    const std::string why(needs_unit);
    for (std::size_t i = 0; i < scene_.lights.size(); ++i)
        if (!lights_in_units_.empty() && lights_in_units_[i] != nullptr)
            reader_.fail(item_path("lights", i) + "." + lights_in_units_[i], why);
    for (const auto& [name, entry] : scene_.models)
        if (entry.is_photometric) reader_.fail("models." + name + ".photometric", why);
}

void SceneReader::use_units() {
    const std::optional<double> lux = unit_lux(scene_.environment);
    if (!lux) return;
    for (std::size_t i = 0; i < scene_.lights.size(); ++i)
        if (lights_in_units_[i] != nullptr)
            scene_.lights[i].intensity = static_cast<float>(scene_.lights[i].intensity / *lux);
    for (auto& [name, entry] : scene_.models)
        if (entry.is_photometric) entry.model = in_scene_units(*entry.model, *lux);
}

void SceneReader::check_daylight() {
    const json* const given = reader_.find("environment");
    if (!given || !given->is_object() || !given->contains("daylight")) return;
    for (const char* made : {"ambient", "background"})
        if (given->contains(made))
            reader_.fail(std::string("environment.") + made, "is made by environment.daylight; leave one of them out");
}

void SceneReader::check_groups() {
    for (std::size_t i = 0; i < scene_.lights.size(); ++i) {
        const Light& light = scene_.lights[i];
        if (light.group.empty()) continue;
        const std::string at = "lights[" + std::to_string(i) + "]";
        if (std::ranges::find(scene_.lights, light.group, &Light::name) != scene_.lights.end())
            reader_.fail(at + ".group", "'" + light.group + "' is the name of a light; groups have others");
        const auto found = std::ranges::find(scene_.lights, light.group, &Light::group);
        const Light& first = *found;
        const auto unit_of = [&](std::size_t of) {
            return of < lights_in_units_.size() ? lights_in_units_[of] : nullptr;
        };
        const bool same_unit = unit_of(i) == unit_of(static_cast<std::size_t>(found - scene_.lights.begin()));
        if (light.color != first.color || light.intensity != first.intensity || !same_unit)
            reader_.fail(at, "has another color or intensity than '" + first.name + "' of its group '" + light.group +
                                 "', which is switched as one");
    }
}

Result<Scene> SceneReader::read() {
    read_parts();
    check_references();
    check_daylight();
    check_units();
    check_groups();
    if (auto done = reader_.finish(); !done) return std::unexpected(done.error());
    use_units();
    add_model_lights();
    if (scene_.lights.size() > max_scene_lights)
        return error(ErrorKind::resource_exhausted,
                     "lights: more than " + std::to_string(max_scene_lights) + " with those of the models");
    if (scene_.environment.daylight) light_by_day();
    return std::move(scene_);
}

void SceneReader::light_by_day() {
    apply_daylight(scene_.environment, scene_.lights);
    for (auto& [name, entry] : scene_.models)
        if (entry.model->sky_radius_m > 0.0) entry.model = daylit_sky(scene_.environment, entry.model->sky_radius_m);
}

/// A list, or an object from names to entries; read by name, for what they say of each other.
FieldOf<Scene> part(const char* name, bool is_list, const char* item, std::size_t limit, const std::string& doc) {
    const std::string most = std::to_string(limit), ref = "{\"$ref\": \"#/$defs/" + std::string(item) + "\"}";
    return {.field = {.name = name,
                      .type = is_list ? "array of objects" : "object",
                      .doc = (is_list ? "" : "from name to entry: ") + doc + "; at most " + most,
                      .fallback = "none",
                      .schema = is_list ? R"({"type": "array", "items": )" + ref + R"(, "maxItems": )" + most + "}"
                                        : R"({"type": "object", "propertyNames": {"$ref": "#/$defs/name"},
                                        "additionalProperties": )" +
                                              ref + R"(, "maxProperties": )" + most + "}"}};
}

FieldOf<Scene> format_version() {
    FieldOf<Scene> entry{.field = {.name = "camrig_scene",
                                   .type = "integer",
                                   .doc = "version of the format: 1",
                                   .required = true,
                                   .schema = R"({"const": 1, "description": "Version of this format."})"}};
    entry.read = [](JsonReader& reader, Changes<Scene>&) {
        int version = 0;
        reader.required("camrig_scene", version);
        if (reader.ok("camrig_scene") && version != 1)
            reader.fail("camrig_scene", "version " + std::to_string(version) + "; this program reads version 1",
                        ErrorKind::unsupported);
    };
    return entry;
}

}  // namespace

FieldTable<Scene> fields_of(std::type_identity<Scene>) {
    static const std::vector<FieldOf<Scene>> table{
        format_version(),
        {.field = {.name = "base",
                   .type = "string",
                   .doc =
                       "of a scene that this one differs from: a file of this folder, or `camrig:` and the name of a "
                       "shipped scene. What is not said here is as there, see base",
                   .fallback = "none"}},
        name_at<&Scene::name>({.name = "name", .required = true}),
        text_at<&Scene::description>({.name = "description", .fallback = "\"\""}),
        field_at<&Scene::seed>({.name = "seed",
                                .doc = "from 0, below 2^64: of everything random; `--seed` overrides it",
                                .schema = R"({"type": "integer", "minimum": 0, "maximum": 18446744073709551615,
                                              "default": 1, "description": "Of everything random in the world."})"}),
        field_at<&Scene::step_ns>({.name = "step_ns",
                                   .doc = "length of a world step",
                                   .unit = "ns",
                                   .range = {double(min_step_ns), double(max_step_ns)}}),
        field_at<&Scene::environment>(
            {.name = "environment", .doc = "see environment", .schema = R"({"$ref": "#/$defs/environment"})"}),
        part("models", false, "model", max_scene_models, "what objects and actors are made of"),
        part("objects", true, "object", max_scene_objects, "things that stand where they are"),
        part("lights", true, "light", max_scene_lights, "those of the models included"),
        part("routes", false, "route", max_scene_routes, "ways over the floor, for actors"),
        part("areas", false, "area", max_scene_areas, "pieces of floor, to wander in and to watch"),
        part("actors", true, "actor", max_scene_actors, "things that move"),
        part("events", true, "event", max_scene_events, "what happens when"),
        part("places", false, "place", max_scene_places, "viewpoints that cameras refer to"),
        part("cameras", true, "camera", max_scene_cameras, "that are there from the start")};
    return table;
}

Result<Scene> read_scene(const json& document, const std::filesystem::path& folder, const ModelSource& models) {
    return SceneReader(document, folder, models).read();
}

}  // namespace camrig::world
