#include "core/world/read/behaviour_json.h"

#include <cmath>

#include "core/world/read/json_parts.h"

namespace camrig {

using nlohmann::json;

namespace {

constexpr double max_seconds = 1e9;

WalkManner read_manner(JsonReader& reader, double default_speed_m_s) {
    WalkManner walk;
    walk.speed_m_s = default_speed_m_s;
    reader.optional("area", walk.area);
    // Who finds the way himself walks; 20 m/s is beyond what avoidance is made for.
    optional_in_range(reader, "speed", walk.speed_m_s, 1e-3, 20.0);
    reader.optional("clip", walk.clip);
    reader.optional("idle_clip", walk.idle_clip);
    return walk;
}

BehaviourSpec read_stand(JsonReader& reader) {
    StandBehaviour stand;
    reader.optional("clip", stand.clip);
    return stand;
}

BehaviourSpec read_route_walk(JsonReader& reader) {
    RouteBehaviour route;
    reader.required("route", route.route);
    optional_in_range(reader, "speed", route.speed_m_s, 1e-3, max_speed_m_s);
    optional_in_range(reader, "start_m", route.start_m, 0.0, 1e9);
    reader.optional("clip", route.clip);
    std::optional<std::string> mode;
    reader.optional("mode", mode);
    using Mode = RouteBehaviour::Mode;
    if (mode == "loop")
        route.mode = Mode::loop;
    else if (mode == "ping_pong")
        route.mode = Mode::ping_pong;
    else if (mode == "once")
        route.mode = Mode::once;
    else if (mode)
        reader.fail("mode", "'" + mode->substr(0, 40) + "' is none of loop, ping_pong, once");
    return route;
}

BehaviourSpec read_go_to(JsonReader& reader) {
    GoToBehaviour go;
    if (!read_vector(reader, "position", go.position)) reader.fail("position", "is missing");
    std::optional<double> yaw_deg;
    reader.optional("yaw_deg", yaw_deg);
    if (yaw_deg) go.yaw_rad = glm::radians(*yaw_deg);
    go.walk = read_manner(reader, 1.3);
    return go;
}

BehaviourSpec read_wander(JsonReader& reader) {
    WanderBehaviour wander;
    if (!reader.has("area")) reader.fail("area", "is missing");
    optional_in_range(reader, "pause_s", wander.pause_s, 0.0, 3600.0);
    wander.walk = read_manner(reader, 1.3);
    return wander;
}

BehaviourSpec read_look_at(JsonReader& reader) {
    LookAtBehaviour look;
    optional_name(reader, "actor", look.actor);
    const bool point = read_vector(reader, "position", look.position);
    if (reader.ok() && point == reader.has("actor")) reader.fail("actor", "give either actor or position");
    reader.optional("clip", look.clip);
    return look;
}

BehaviourSpec read_follow(JsonReader& reader) {
    FollowBehaviour follow;
    required_name(reader, "actor", follow.actor);
    optional_in_range(reader, "distance_m", follow.distance_m, 0.1, 1000.0);
    follow.walk = read_manner(reader, 1.6);
    return follow;
}

BehaviourSpec read_group(JsonReader& reader) {
    GroupBehaviour group;
    required_name(reader, "group", group.group);
    if (!read_vector(reader, "position", group.position)) reader.fail("position", "is missing");
    optional_in_range(reader, "radius_m", group.radius_m, 0.1, 100.0);
    group.walk = read_manner(reader, 1.3);
    return group;
}

BehaviourSpec read_vehicle(JsonReader& reader) {
    VehicleBehaviour vehicle;
    reader.required("route", vehicle.route);
    optional_in_range(reader, "speed", vehicle.speed_m_s, 1e-3, max_speed_m_s);
    optional_in_range(reader, "start_m", vehicle.start_m, 0.0, 1e9);
    optional_in_range(reader, "length_m", vehicle.length_m, 0.1, 100.0);
    optional_in_range(reader, "width_m", vehicle.width_m, 0.1, 20.0);
    optional_in_range(reader, "headway_s", vehicle.headway_s, 0.1, 60.0);
    optional_in_range(reader, "gap_m", vehicle.gap_m, 0.1, 100.0);
    optional_in_range(reader, "acceleration", vehicle.acceleration_m_s2, 0.01, 100.0);
    optional_in_range(reader, "braking", vehicle.braking_m_s2, 0.01, 100.0);
    reader.optional("clip", vehicle.clip);
    return vehicle;
}

BehaviourSpec read_steered(JsonReader& reader) {
    SteeredBehaviour steered;
    reader.optional("clip", steered.clip);
    return steered;
}

Result<SequenceStep> read_step(const json& value, const std::string& path, int depth) {
    // A step is a behaviour with one key more.
    if (!value.is_object()) return error(ErrorKind::invalid_argument, path + ": expected an object");
    json behaviour = value;
    SequenceStep step;
    if (const auto found = behaviour.find("until"); found != behaviour.end()) {
        const json until = std::move(*found);
        behaviour.erase(found);
        JsonReader reader(until, path + ".until");
        double seconds = 0.0;
        optional_in_range(reader, "seconds", seconds, 0.0, max_seconds);
        optional_name(reader, "event", step.event);
        if (reader.has("seconds")) step.duration_ns = std::llround(seconds * 1e9);
        if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    }
    auto read = read_behaviour(behaviour, path, depth);
    if (!read) return std::unexpected(read.error());
    step.behaviour = std::move(*read);
    return step;
}

BehaviourSpec read_sequence(JsonReader& reader, int depth) {
    SequenceBehaviour sequence;
    const auto steps = reader.array("steps", max_sequence_steps);
    if (reader.ok() && steps.empty()) reader.fail("steps", "expected 1 to 64 behaviours");
    if (depth >= max_sequence_depth) reader.fail("steps", "sequences nest at most 4 deep");
    for (std::size_t i = 0; i < steps.size() && depth < max_sequence_depth; ++i) {
        auto step = read_step(steps[i], item_path(reader.path_of("steps"), i), depth + 1);
        if (step)
            sequence.steps.push_back(std::move(*step));
        else
            reader.fail(step.error());
    }
    reader.optional("repeat", sequence.repeat);
    return sequence;
}

}  // namespace

Result<BehaviourSpec> read_behaviour(const json& value, const std::string& path, int depth) {
    JsonReader reader(value, path);
    std::string type;
    reader.required("type", type);
    BehaviourSpec spec;
    if (type == "stand")
        spec = read_stand(reader);
    else if (type == "route")
        spec = read_route_walk(reader);
    else if (type == "go_to")
        spec = read_go_to(reader);
    else if (type == "wander")
        spec = read_wander(reader);
    else if (type == "look_at")
        spec = read_look_at(reader);
    else if (type == "follow")
        spec = read_follow(reader);
    else if (type == "group")
        spec = read_group(reader);
    else if (type == "vehicle")
        spec = read_vehicle(reader);
    else if (type == "steered")
        spec = read_steered(reader);
    else if (type == "sequence")
        spec = read_sequence(reader, depth);
    else {
        reader.allow_unknown();
        if (reader.ok())
            reader.fail("type",
                        "'" + type.substr(0, 40) +
                            "' is none of stand, route, go_to, wander, look_at, follow, group, vehicle, steered, "
                            "sequence");
    }
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return spec;
}

}  // namespace camrig
