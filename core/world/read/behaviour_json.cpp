#include "core/world/read/behaviour_json.h"

#include <algorithm>

#include "core/world/world_fields.h"

namespace camrig::world {

using nlohmann::json;

std::span<const Named<RouteBehaviour::Mode>> names_of(std::type_identity<RouteBehaviour::Mode>) {
    using Mode = RouteBehaviour::Mode;
    static constexpr Named<Mode> names[] = {{Mode::loop, "loop"}, {Mode::ping_pong, "ping_pong"}, {Mode::once, "once"}};
    return names;
}

namespace {

/// How deep sequences lie in each other, at most one more than they may.
int sequence_depth(const json& behaviour, int limit = max_sequence_depth + 1) {
    const auto steps = behaviour.find("steps");
    if (limit == 0 || steps == behaviour.end() || !steps->is_array()) return 0;
    int deepest = 0;
    for (const json& step : *steps)
        if (step.is_object()) deepest = std::max(deepest, sequence_depth(step, limit - 1));
    return deepest + 1;
}

template <auto member>
auto clip_at(std::string doc = "an animation of its model, played in a loop") {
    return field_at<member>({.name = "clip", .doc = std::move(doc), .fallback = "none"});
}

FieldOf<WalkManner> walking_area(bool is_required) {
    return field_at<&WalkManner::area>(
        {.name = "area",
         .doc = is_required ? "a name of `areas`" : "a name of `areas`; none: open ground",
         .required = is_required,
         .fallback = is_required ? "" : "none"});
}

/// Walkers find their way; 20 m/s is beyond what avoidance is made for.
std::vector<FieldOf<WalkManner>> walking(const std::string& usual_speed = "", bool needs_area = false) {
    return {walking_area(needs_area),
            field_at<&WalkManner::speed_m_s>(
                {.name = "speed", .unit = "m/s", .fallback = usual_speed, .range = {1e-3, 20.0}}),
            clip_at<&WalkManner::clip>("while it walks"),
            field_at<&WalkManner::idle_clip>({.name = "idle_clip", .doc = "while it stands", .fallback = "none"})};
}

template <typename T>
std::vector<FieldOf<T>> walked(std::vector<FieldOf<T>> table, const std::vector<FieldOf<WalkManner>>& walk) {
    add_inner<&T::walk>(table, walk);
    return table;
}

std::vector<FieldOf<RouteBehaviour>> route_fields() {
    return {field_at<&RouteBehaviour::route>({.name = "route", .doc = "a name of `routes`", .required = true}),
            field_at<&RouteBehaviour::speed_m_s>({.name = "speed", .unit = "m/s", .range = {1e-3, max_speed_m_s}}),
            field_at<&RouteBehaviour::start_m>(
                {.name = "start_m", .doc = "how far along the route it starts", .unit = "m", .range = {0.0, 1e9}}),
            field_at<&RouteBehaviour::mode>(
                {.name = "mode",
                 .doc = "closed routes take `loop` and `once`; open ones `ping_pong` (turns round at the ends) and "
                        "`once` (stops at the end)",
                 .fallback = "`loop`, of open routes `ping_pong`"}),
            clip_at<&RouteBehaviour::clip>()};
}

std::vector<FieldOf<VehicleBehaviour>> vehicle_fields() {
    using Vehicle = VehicleBehaviour;
    return {
        field_at<&Vehicle::route>({.name = "route", .doc = "a name of `routes`", .required = true}),
        field_at<&Vehicle::speed_m_s>(
            {.name = "speed", .doc = "where nothing is in the way", .unit = "m/s", .range = {1e-3, max_speed_m_s}}),
        field_at<&Vehicle::start_m>(
            {.name = "start_m", .doc = "how far along the route it starts", .unit = "m", .range = {0.0, 1e9}}),
        field_at<&Vehicle::length_m>(
            {.name = "length_m", .doc = "about its origin", .unit = "m", .range = {0.1, 100.0}}),
        field_at<&Vehicle::width_m>({.name = "width_m", .doc = "about its origin", .unit = "m", .range = {0.1, 20.0}}),
        field_at<&Vehicle::headway_s>(
            {.name = "headway_s", .doc = "time to what drives ahead", .unit = "s", .range = {0.1, 60.0}}),
        field_at<&Vehicle::gap_m>(
            {.name = "gap_m", .doc = "distance to what it stands behind", .unit = "m", .range = {0.1, 100.0}}),
        field_at<&Vehicle::acceleration_m_s2>(
            {.name = "acceleration", .doc = "a comfortable one", .unit = "m/s^2", .range = {0.01, 100.0}}),
        field_at<&Vehicle::braking_m_s2>(
            {.name = "braking", .doc = "a comfortable one", .unit = "m/s^2", .range = {0.01, 100.0}}),
        clip_at<&Vehicle::clip>()};
}

Result<SequenceStep> read_step(const json& value, const std::string& path);

std::vector<FieldOf<SequenceBehaviour>> sequence_fields() {
    return {
        list_at<&SequenceBehaviour::steps>(
            {.name = "steps",
             .doc = "1 to 64 behaviours, each may have `until`; sequences nest at most 4 deep",
             .required = true,
             .schema = R"({"type": "array", "items": {"$ref": "#/$defs/behaviour"}, "minItems": 1, "maxItems": 64})"},
            max_sequence_steps, read_step),
        field_at<&SequenceBehaviour::repeat>(
            {.name = "repeat", .doc = "begins again after the last one, which else goes on"})};
}

std::vector<Kind<BehaviourSpec>> make_kinds() {
    const auto point = [](auto make, const char* doc) {
        return make(Field{.name = "position", .doc = doc, .required = true});
    };
    std::vector<Kind<BehaviourSpec>> kinds{
        kind_of<BehaviourSpec, StandBehaviour>({.name = "stand", .doc = "stays"}, {clip_at<&StandBehaviour::clip>()}),
        kind_of<BehaviourSpec, RouteBehaviour>({.name = "route",
                                                .doc = "walks along a route, which places the actor: `position`, "
                                                       "`yaw_deg` and `orientation` are errors then"},
                                               route_fields()),
        kind_of<BehaviourSpec, GoToBehaviour>(
            {.name = "go_to", .doc = "walks to a point and stays there"},
            walked<GoToBehaviour>(
                {point(vector_at<&GoToBehaviour::position>, "where to"),
                 degrees_at<&GoToBehaviour::yaw_rad>(
                     {.name = "yaw_deg", .doc = "how it stands when it is there", .fallback = "as it came"})},
                walking())),
        kind_of<BehaviourSpec, WanderBehaviour>(
            {.name = "wander", .doc = "walks from one random point of its area to the next"},
            walked<WanderBehaviour>(
                {field_at<&WanderBehaviour::pause_s>({.name = "pause_s",
                                                      .doc = "mean time that it stands at each point",
                                                      .unit = "s",
                                                      .range = {0.0, 3600.0}})},
                walking("", true))),
        kind_of<BehaviourSpec, LookAtBehaviour>(
            {.name = "look_at",
             .doc = "stays and turns to somebody or something",
             .rule = R"({"oneOf": [{"required": ["actor"]}, {"required": ["position"]}]})"},
            {name_at<&LookAtBehaviour::actor>({.name = "actor", .doc = "whom it looks at; or position"}),
             vector_at<&LookAtBehaviour::position>({.name = "position", .doc = "what it looks at; or actor"}),
             clip_at<&LookAtBehaviour::clip>()},
            [](const LookAtBehaviour& look, JsonReader& reader) {
                if (look.actor.empty() != reader.has("position")) reader.fail("actor", "give either actor or position");
            }),
        kind_of<BehaviourSpec, FollowBehaviour>(
            {.name = "follow", .doc = "walks behind another; nobody follows himself, however far round"},
            walked<FollowBehaviour>(
                {name_at<&FollowBehaviour::actor>({.name = "actor", .doc = "behind whom", .required = true}),
                 field_at<&FollowBehaviour::distance_m>({.name = "distance_m", .unit = "m", .range = {0.1, 1000.0}})},
                walking("1.6"))),
        kind_of<BehaviourSpec, GroupBehaviour>(
            {.name = "group",
             .doc = "all of one group stand in a circle and face its middle; it closes and opens as they come and go"},
            walked<GroupBehaviour>(
                {name_at<&GroupBehaviour::group>({.name = "group", .doc = "any name", .required = true}),
                 point(vector_at<&GroupBehaviour::position>, "the middle"),
                 field_at<&GroupBehaviour::radius_m>({.name = "radius_m", .unit = "m", .range = {0.1, 100.0}})},
                walking())),
        kind_of<BehaviourSpec, VehicleBehaviour>(
            {.name = "vehicle",
             .doc = "drives along a route, which places it, and keeps its distance from whatever is on the lane ahead; "
                    "at the end of an open route it stops"},
            vehicle_fields()),
        kind_of<BehaviourSpec, SteeredBehaviour>({.name = "steered", .doc = "moves as `actor.steer` says"},
                                                 {clip_at<&SteeredBehaviour::clip>()}),
        kind_of<BehaviourSpec, SequenceBehaviour>({.name = "sequence", .doc = "one behaviour after the other"},
                                                  sequence_fields(),
                                                  [](const SequenceBehaviour& sequence, JsonReader& reader) {
                                                      if (sequence.steps.empty())
                                                          reader.fail("steps", "expected 1 to 64 behaviours");
                                                  })};
    CHECK(kinds.size() == std::variant_size_v<BehaviourSpec>);
    return kinds;
}

/// What ends a step.
struct Until {
    std::optional<TimeNs> duration_ns;
    std::string event;
};

Result<Until> read_until(const json& value, const std::string& path) {
    static const std::vector<FieldOf<Until>> table{seconds_at<&Until::duration_ns>({.name = "seconds"}),
                                                   name_at<&Until::event>({.name = "event"})};
    JsonReader reader(value, path);
    return read_all(table, reader);
}

/// A step is a behaviour with one key more.
Result<SequenceStep> read_step(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    SequenceStep step;
    if (const json* given = reader.find("until")) {
        if (auto until = read_until(*given, reader.path_of("until"))) {
            step.duration_ns = until->duration_ns;
            step.event = until->event;
        } else {
            reader.fail(until.error());
        }
    }
    step.behaviour = read_kind(behaviour_kinds(), reader, "type");
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return step;
}

}  // namespace

const std::vector<Kind<BehaviourSpec>>& behaviour_kinds() {
    static const std::vector<Kind<BehaviourSpec>> kinds = make_kinds();
    return kinds;
}

std::string_view type_name(const BehaviourSpec& behaviour) {
    return behaviour_kinds()[behaviour.index()].description.name;
}

bool places_actor(const BehaviourSpec& behaviour) {
    return std::holds_alternative<RouteBehaviour>(behaviour) || std::holds_alternative<VehicleBehaviour>(behaviour);
}

Result<BehaviourSpec> read_behaviour(const json& value, const std::string& path) {
    if (value.is_object() && sequence_depth(value) > max_sequence_depth)
        return error(ErrorKind::invalid_argument, path + ".steps: sequences nest at most 4 deep");
    return read_whole_kind(behaviour_kinds(), value, path, "type");
}

}  // namespace camrig::world
