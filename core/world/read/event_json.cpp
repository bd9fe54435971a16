#include "core/world/read/event_json.h"

#include <cmath>

#include "core/world/camera_json.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/behaviour_json.h"
#include "core/world/read/json_parts.h"

namespace camrig {

using nlohmann::json;

namespace {

constexpr double longest_s = 1e9;  // 31 years

TimeNs read_seconds(JsonReader& reader, std::string_view key, double low_s) {
    double seconds = 0.0;
    reader.required(key, seconds);
    optional_in_range(reader, key, seconds, low_s, longest_s);
    return reader.ok() ? std::llround(seconds * 1e9) : 0;
}

std::optional<TimeNs> optional_seconds(JsonReader& reader, std::string_view key) {
    if (!reader.find(key)) return std::nullopt;
    return read_seconds(reader, key, 0.0);
}

Trigger read_border(JsonReader& reader, const char* key) {
    AtBorder border;
    border.enters = std::string_view(key) == "enter";
    required_name(reader, key, border.area);
    optional_name(reader, "actor", border.actor);
    optional_name(reader, "class", border.object_class);
    return border;
}

Trigger read_meeting(JsonReader& reader) {
    AtMeeting meeting;
    const auto names = reader.array("meet", 2);
    bool good = names.size() == 2;
    for (std::size_t i = 0; good && i < 2; ++i) {
        good = names[i].is_string() && is_scene_name(names[i].get_ref<const std::string&>());
        if (good) meeting.actors[i] = names[i].get<std::string>();
    }
    if (!good) reader.fail("meet", "expected the names of two actors");
    if (reader.ok() && meeting.actors[0] == meeting.actors[1]) reader.fail("meet", "expected two different actors");
    optional_in_range(reader, "distance_m", meeting.distance_m, 0.01, 1000.0);
    return meeting;
}

Result<Trigger> read_trigger(const json& value, std::string path) {
    JsonReader reader(value, std::move(path));
    constexpr const char* kinds[] = {"at_s", "every_s", "enter", "leave", "meet", "event", "arrived"};
    const char* kind = nullptr;
    for (const char* key : kinds) {
        if (!reader.has(key)) continue;
        if (kind) reader.fail(key, "give only one of at_s, every_s, enter, leave, meet, event, arrived");
        kind = key;
    }
    const std::string_view name = kind ? kind : "";
    Trigger trigger;
    if (name == "at_s") {
        trigger = AtTime{read_seconds(reader, "at_s", 0.0)};
    } else if (name == "every_s") {
        EveryTime every{.period_ns = read_seconds(reader, "every_s", 0.001)};
        every.first_ns = optional_seconds(reader, "from_s").value_or(every.period_ns);
        trigger = every;
    } else if (name == "enter" || name == "leave") {
        trigger = read_border(reader, kind);
    } else if (name == "meet") {
        trigger = read_meeting(reader);
    } else if (name == "event") {
        AfterEvent after;
        required_name(reader, "event", after.event);
        after.delay_ns = optional_seconds(reader, "after_s").value_or(0);
        trigger = after;
    } else if (name == "arrived") {
        AtArrival arrival;
        required_name(reader, "arrived", arrival.actor);
        trigger = arrival;
    } else if (reader.ok()) {
        reader.allow_unknown();
        reader.fail({ErrorKind::invalid_argument,
                     reader.path() + ": give one of at_s, every_s, enter, leave, meet, event, arrived"});
    }
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return trigger;
}

Action read_behave(JsonReader& reader) {
    BehaveAction action;
    required_name(reader, "actor", action.actor);
    if (const json* value = reader.find("behaviour")) {
        auto behaviour = read_behaviour(*value, reader.path_of("behaviour"));
        if (behaviour)
            action.behaviour = std::move(*behaviour);
        else
            reader.fail(behaviour.error());
    } else {
        reader.fail("behaviour", "is missing");
    }
    return action;
}

Action read_play(JsonReader& reader) {
    PlayAction action;
    required_name(reader, "actor", action.actor);
    reader.required("clip", action.clip);
    optional_in_range(reader, "speed", action.speed, 0.0, 100.0);
    action.duration_ns = optional_seconds(reader, "seconds");
    return action;
}

Action read_spawn(JsonReader& reader) {
    SpawnAction action;
    const json* value = reader.find("actor");
    if (!value) {
        reader.fail("actor", "is missing");
        return action;
    }
    JsonReader nested(*value, reader.path_of("actor"));
    auto actor = read_actor(nested);
    if (actor)
        action.actor = std::move(*actor);
    else
        reader.fail(actor.error());
    return action;
}

Action read_pick_up(JsonReader& reader) {
    PickUpAction action;
    required_name(reader, "object", action.object);
    required_name(reader, "actor", action.to.actor);
    reader.optional("node", action.to.node);
    read_vector(reader, "position", action.to.position);
    read_orientation(reader, action.to.orientation);
    return action;
}

Action read_put_down(JsonReader& reader) {
    PutDownAction action;
    required_name(reader, "object", action.object);
    glm::dvec3 position(0.0);
    if (read_vector(reader, "position", position)) action.position = position;
    return action;
}

void optional_color_of(JsonReader& reader, const char* key, std::optional<glm::vec3>& out) {
    if (reader.find(key)) optional_color(reader, key, out.emplace(0.0f));
}

Action read_light_change(JsonReader& reader) {
    LightAction action;
    required_name(reader, "light", action.light);
    if (reader.find("intensity")) optional_in_range(reader, "intensity", action.intensity.emplace(), 0.0, 1e9);
    optional_color_of(reader, "color", action.color);
    optional_in_range(reader, "flicker_hz", action.flicker_hz, 0.0, 50.0);
    action.duration_ns = optional_seconds(reader, "seconds");
    if (reader.ok() && action.duration_ns && action.flicker_hz == 0.0) reader.fail("seconds", "belongs to flicker_hz");
    return action;
}

Action read_environment_change(JsonReader& reader) {
    EnvironmentAction action;
    optional_color_of(reader, "background", action.background);
    optional_color_of(reader, "sky", action.sky);
    optional_color_of(reader, "ground", action.ground);
    if (reader.find("exposure")) optional_in_range(reader, "exposure", action.exposure.emplace(), 1e-6, 1e6);
    return action;
}

Action read_camera_move(JsonReader& reader) {
    CameraAction action;
    reader.required("camera", action.camera);
    if (const json* value = reader.find("pose")) {
        auto pose = read_pose(*value, reader.path_of("pose"));
        if (pose)
            action.pose = *pose;
        else
            reader.fail(pose.error());
    }
    std::optional<double> vfov_deg;
    reader.optional("vfov_deg", vfov_deg);
    if (vfov_deg && !(*vfov_deg > 0.01 && *vfov_deg < 179.9))
        reader.fail("vfov_deg", "must be over 0.01 and below 179.9");
    if (vfov_deg) action.vfov_rad = glm::radians(*vfov_deg);
    if (reader.ok() && !action.pose && !action.vfov_rad) reader.fail("pose", "give it, or vfov_deg, or both");
    action.duration_ns = optional_seconds(reader, "seconds").value_or(0);
    return action;
}

Action read_user(JsonReader& reader) {
    UserAction action{"null"};
    if (const json* value = reader.find("data"))
        action.data = value->dump(-1, ' ', false, json::error_handler_t::replace);
    if (action.data.size() > max_user_data_bytes) reader.fail("data", "more than 4096 bytes of JSON");
    return action;
}

Result<Action> read_action(const json& value, std::string path) {
    JsonReader reader(value, std::move(path));
    std::string kind;
    reader.required("action", kind);
    const auto of_actor = [&](auto action) {
        required_name(reader, "actor", action.actor);
        return action;
    };
    Action action;
    if (kind == "behave") {
        action = read_behave(reader);
    } else if (kind == "stop") {
        StopAction stop = of_actor(StopAction{});
        reader.optional("clip", stop.clip);
        action = stop;
    } else if (kind == "start") {
        action = of_actor(StartAction{});
    } else if (kind == "play") {
        action = read_play(reader);
    } else if (kind == "spawn") {
        action = read_spawn(reader);
    } else if (kind == "remove") {
        action = of_actor(RemoveAction{});
    } else if (kind == "pick_up") {
        action = read_pick_up(reader);
    } else if (kind == "put_down") {
        action = read_put_down(reader);
    } else if (kind == "light") {
        action = read_light_change(reader);
    } else if (kind == "environment") {
        action = read_environment_change(reader);
    } else if (kind == "camera") {
        action = read_camera_move(reader);
    } else if (kind == "user") {
        action = read_user(reader);
    } else {
        reader.allow_unknown();
        if (reader.ok())
            reader.fail("action",
                        "'" + kind.substr(0, 40) +
                            "' is none of behave, stop, start, play, spawn, remove, pick_up, put_down, light, "
                            "environment, camera, user");
    }
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return action;
}

}  // namespace

Result<EventSpec> read_event(JsonReader& reader) {
    EventSpec event;
    required_name(reader, "name", event.name);
    if (const json* value = reader.find("when")) {
        auto trigger = read_trigger(*value, reader.path_of("when"));
        if (trigger)
            event.when = std::move(*trigger);
        else
            reader.fail(trigger.error());
    } else {
        reader.fail("when", "is missing");
    }
    const auto items = reader.array("do", max_event_actions);
    for (std::size_t i = 0; i < items.size(); ++i) {
        auto action = read_action(items[i], item_path(reader.path_of("do"), i));
        if (action)
            event.actions.push_back(std::move(*action));
        else
            reader.fail(action.error());
    }
    reader.optional("limit", event.limit);
    if (reader.ok("limit") && event.limit < 0) reader.fail("limit", "expected an integer from 0");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return event;
}

}  // namespace camrig
