#include "core/world/read/event_json.h"

#include "core/world/camera_json.h"
#include "core/world/read/actor_json.h"
#include "core/world/read/behaviour_json.h"
#include "core/world/read/daylight_json.h"
#include "core/world/read/fault_json.h"
#include "core/world/read/light_json.h"
#include "core/world/world_fields.h"

namespace camrig::world {

using nlohmann::json;

namespace {

template <auto member>
auto required_name_at(const char* name, std::string doc) {
    return name_at<member>({.name = name, .doc = std::move(doc), .required = true});
}

Kind<Trigger> border_kind(bool enters) {
    const std::string name = enters ? "enter" : "leave";
    return kind_of<Trigger, AtBorder>(
        {.name = name,
         .doc = enters ? "when an actor crosses the border of an area inwards; who is born within has entered"
                       : "when an actor crosses the border of an area outwards"},
        {required_name_at<&AtBorder::area>(name.c_str(), "name of the area"),
         name_at<&AtBorder::actor>({.name = "actor", .doc = "which one", .fallback = "any"}),
         name_at<&AtBorder::object_class>({.name = "class", .doc = "those of a class", .fallback = "any"})},
        {}, {.enters = enters, .area = {}, .actor = {}, .object_class = {}});
}

void read_two_names(JsonReader& reader, std::string_view key, std::array<std::string, 2>& out) {
    const auto names = reader.array(key, 2);
    bool good = names.size() == 2;
    for (std::size_t i = 0; good && i < 2; ++i) {
        good = names[i].is_string() && is_scene_name(names[i].get_ref<const std::string&>());
        if (good) out[i] = names[i].get<std::string>();
    }
    if (!good) reader.fail(key, "expected the names of two actors");
    if (reader.ok(key) && out[0] == out[1]) reader.fail(key, "expected two different actors");
}

std::vector<Kind<Trigger>> make_triggers() {
    return {
        kind_of<Trigger, AtTime>({.name = "at_s", .doc = "once, at a world time"},
                                 {seconds_at<&AtTime::at_ns>({.name = "at_s", .doc = "when", .required = true})}),
        kind_of<Trigger, EveryTime>(
            {.name = "every_s", .doc = "again and again, at most once a step of the world"},
            {seconds_at<&EveryTime::period_ns>(
                 {.name = "every_s", .doc = "period", .required = true, .range = {0.001}}),
             seconds_at<&EveryTime::first_ns>({.name = "from_s", .doc = "first at", .fallback = "after one period"})}),
        border_kind(true),
        border_kind(false),
        kind_of<Trigger, AtMeeting>(
            {.name = "meet", .doc = "when two actors come near each other"},
            {entry_by<&AtMeeting::actors>({.name = "meet",
                                           .type = "[string, string]",
                                           .doc = "the names of two actors",
                                           .required = true,
                                           .schema = R"({"type": "array", "items": {"$ref": "#/$defs/name"},
                                                         "minItems": 2, "maxItems": 2, "uniqueItems": true})"},
                                          read_two_names),
             field_at<&AtMeeting::distance_m>(
                 {.name = "distance_m", .doc = "how near", .unit = "m", .range = {0.01, 1000.0}})}),
        kind_of<Trigger, AfterEvent>(
            {.name = "event", .doc = "when another event has fired"},
            {required_name_at<&AfterEvent::event>("event", "name of the event; a circle of those is an error"),
             seconds_at<&AfterEvent::delay_ns>(
                 {.name = "after_s", .doc = "so long after it", .fallback = "0: at the same instant"})}),
        kind_of<Trigger, AtArrival>({.name = "arrived", .doc = "when an actor has done what its behaviour is to do"},
                                    {required_name_at<&AtArrival::actor>("arrived", "name of the actor")})};
}

Result<Trigger> read_trigger(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    std::string names;
    for (const auto& kind : trigger_kinds()) names += (names.empty() ? "" : ", ") + kind.description.name;
    const Kind<Trigger>* given = nullptr;
    for (const auto& kind : trigger_kinds()) {
        if (!reader.has(kind.description.name)) continue;
        if (given) reader.fail(kind.description.name, "give only one of " + names);
        given = &kind;
    }
    Trigger trigger;
    if (given) {
        trigger = given->read(reader);
    } else if (reader.ok()) {
        reader.allow_unknown();
        reader.fail({ErrorKind::invalid_argument, reader.path() + ": give one of " + names});
    }
    if (auto done = reader.finish(); !done) return std::unexpected(done.error());
    return trigger;
}

/// What an action does to a light or the surroundings: not given, it stays.
template <auto member>
auto new_color(const char* name) {
    return color_at<member>({.name = name, .fallback = "as it is"});
}

template <typename T>
auto clip_length() {
    return seconds_at<&T::duration_ns>({.name = "seconds", .doc = "for how long", .fallback = "until told otherwise"});
}

std::vector<FieldOf<PickUpAction>> pick_up_fields() {
    std::vector<FieldOf<PickUpAction>> table{required_name_at<&PickUpAction::object>("object", "an object or actor")};
    add_inner<&PickUpAction::to>(table, fields_of(std::type_identity<Attachment>{}));
    return table;
}

std::vector<FieldOf<FaultAction>> fault_action_fields() {
    std::vector<FieldOf<FaultAction>> table{
        field_at<&FaultAction::camera>({.name = "camera", .doc = "its name", .required = true})};
    add_inner<&FaultAction::fault>(table, fault_fields());
    table.push_back(seconds_at<&FaultAction::duration_ns>(
        {.name = "seconds", .doc = "world time that it lasts", .fallback = "until it is cleared"}));
    return table;
}

void read_user_data(JsonReader& reader, std::string_view key, std::string& out) {
    out = reader.find(key)->dump(-1, ' ', false, json::error_handler_t::replace);
    if (out.size() > max_user_data_bytes) reader.fail(key, "more than 4096 bytes of JSON");
}

/// Of one actor, that the action names.
template <typename T>
std::vector<FieldOf<T>> of_actor(std::vector<FieldOf<T>> others = {}) {
    others.insert(others.begin(), required_name_at<&T::actor>("actor", "name of the actor"));
    return others;
}

Result<ActorSpec> read_spawned(const json& value, const std::string& path) {
    JsonReader reader(value, path);
    return read_actor(reader);
}

std::vector<Kind<Action>> make_actions() {
    std::vector<Kind<Action>> kinds{
        kind_of<Action, BehaveAction>(
            {.name = "behave", .doc = "gives an actor another behaviour"},
            of_actor<BehaveAction>({nested_at<&BehaveAction::behaviour>({.name = "behaviour",
                                                                         .doc = "see behaviours",
                                                                         .required = true,
                                                                         .shape = "Behaviour",
                                                                         .schema = R"({"$ref": "#/$defs/behaviour"})"},
                                                                        read_behaviour)})),
        kind_of<Action, StopAction>({.name = "stop", .doc = "holds an actor where it is"},
                                    of_actor<StopAction>({field_at<&StopAction::clip>(
                                        {.name = "clip", .doc = "that it plays meanwhile", .fallback = "none"})})),
        kind_of<Action, StartAction>({.name = "start", .doc = "lets it go on"}, of_actor<StartAction>()),
        kind_of<Action, PlayAction>(
            {.name = "play", .doc = "plays a clip over that of the behaviour"},
            of_actor<PlayAction>(
                {field_at<&PlayAction::clip>({.name = "clip", .doc = "empty: no longer", .required = true}),
                 field_at<&PlayAction::speed>({.name = "speed", .doc = "of the clip", .range = {0.0, 100.0}}),
                 clip_length<PlayAction>()})),
        kind_of<Action, SpawnAction>({.name = "spawn", .doc = "an actor comes"},
                                     {nested_at<&SpawnAction::actor>({.name = "actor",
                                                                      .doc = "all of it, as among the `actors`",
                                                                      .required = true,
                                                                      .schema = R"({"$ref": "#/$defs/actor"})"},
                                                                     read_spawned)}),
        kind_of<Action, RemoveAction>({.name = "remove", .doc = "an actor goes; what it carries is put down"},
                                      of_actor<RemoveAction>()),
        kind_of<Action, PickUpAction>(
            {.name = "pick_up", .doc = "hangs an object (or actor) on an actor", .rule = one_orientation},
            pick_up_fields()),
        kind_of<Action, PutDownAction>(
            {.name = "put_down", .doc = "puts it down"},
            {required_name_at<&PutDownAction::object>("object", "an object or actor"),
             vector_at<&PutDownAction::position>({.name = "position", .fallback = "on the floor below"})}),
        kind_of<Action, LightAction>(
            {.name = "light", .doc = "changes a light", .rule = R"({"dependentRequired": {"seconds": ["flicker_hz"]},
                         "not": {"anyOf": [{"required": ["candela", "intensity"]}, {"required": ["lux", "intensity"]},
                                           {"required": ["candela", "lux"]}]}})"},
            {required_name_at<&LightAction::light>("light", "name of the light, or of a group of them"),
             field_at<&LightAction::intensity>({.name = "intensity", .fallback = "as it is", .range = {0.0, 1e9}}),
             field_at<&LightAction::candela>({.name = "candela",
                                              .doc = "of a point light or spot: instead of intensity, where the scene "
                                                     "has a unit (see units)",
                                              .unit = "cd",
                                              .fallback = "as it is",
                                              .range = {0.0, 1e12}}),
             field_at<&LightAction::lux>({.name = "lux",
                                          .doc = "of a directional light: instead of intensity, where the scene has a "
                                                 "unit (see units)",
                                          .unit = "lx",
                                          .fallback = "as it is",
                                          .range = {0.0, 1e12}}),
             new_color<&LightAction::color>("color"),
             field_at<&LightAction::flicker_hz>({.name = "flicker_hz",
                                                 .doc = "over 0: it goes on and off by chance, so often a second",
                                                 .unit = "Hz",
                                                 .range = {0.0, 50.0}}),
             clip_length<LightAction>()},
            [](const LightAction& action, JsonReader& reader) {
                if (action.duration_ns && action.flicker_hz == 0.0) reader.fail("seconds", "belongs to flicker_hz");
                if (action.intensity.has_value() + action.candela.has_value() + action.lux.has_value() > 1)
                    reader.fail("intensity", "give one of intensity, candela and lux");
            }),
        kind_of<Action, EnvironmentAction>(
            {.name = "environment", .doc = "changes the surroundings"},
            {new_color<&EnvironmentAction::background>("background"), new_color<&EnvironmentAction::sky>("sky"),
             new_color<&EnvironmentAction::ground>("ground"),
             field_at<&EnvironmentAction::exposure>({.name = "exposure", .fallback = "as it is", .range = {1e-6, 1e6}}),
             field_at<&EnvironmentAction::glow>({.name = "glow", .fallback = "as it is", .range = {0.0, 1e6}}),
             nested_at<&EnvironmentAction::daylight>({.name = "daylight",
                                                      .doc = "of the environment",
                                                      .fallback = "as it is",
                                                      .schema = R"({"$ref": "#/$defs/daylight"})"},
                                                     read_daylight),
             nested_at<&EnvironmentAction::fog>({.name = "fog",
                                                 .doc = "of the environment",
                                                 .fallback = "as it is",
                                                 .schema = R"({"$ref": "#/$defs/fog"})"},
                                                read_fog)},
            [](const EnvironmentAction& action, JsonReader& reader) {
                for (const char* made : {"background", "sky"})
                    if (action.daylight && reader.has(made)) reader.fail(made, "is made by daylight; leave it out");
            }),
        kind_of<Action, CameraAction>(
            {.name = "camera",
             .doc = "puts a camera somewhere else, gives it another field of view, sets its clock, or several of them",
             .rule = R"({"anyOf": [{"required": ["pose"]}, {"required": ["vfov_deg"]}, {"required": ["clock"]}]})"},
            {field_at<&CameraAction::camera>({.name = "camera", .doc = "its name", .required = true}),
             nested_at<&CameraAction::pose>(
                 {.name = "pose", .doc = "as of a camera", .schema = R"({"$ref": "#/$defs/pose"})"}, read_pose),
             degrees_at<&CameraAction::vfov_rad>(
                 {.name = "vfov_deg",
                  .doc = "vertical field of view",
                  .range = {.low = 0.01, .high = 179.9, .is_low_out = true, .is_high_out = true}}),
             field_at<&CameraAction::clock>({.name = "clock",
                                             .doc = "as of a camera, at once; what is not given in it has its default",
                                             .fallback = "as it is"}),
             seconds_at<&CameraAction::duration_ns>(
                 {.name = "seconds", .doc = "world time in which it gets there", .fallback = "0"})},
            [](const CameraAction& action, JsonReader& reader) {
                if (!action.pose && !action.vfov_rad && !action.clock)
                    reader.fail("pose", "give it, or vfov_deg, or clock");
            }),
        kind_of<Action, FaultAction>({.name = "fault", .doc = "a camera fails ([faults](faults.md))"},
                                     fault_action_fields()),
        kind_of<Action, ClearFaultAction>(
            {.name = "clear_fault", .doc = "a camera does not fail any more"},
            {field_at<&ClearFaultAction::camera>({.name = "camera", .doc = "its name", .required = true}),
             entry_by<&ClearFaultAction::kind>({.name = "kind",
                                                .type = "string",
                                                .doc = "of which kind",
                                                .fallback = "all",
                                                .choices = fault_names()},
                                               read_fault_name)}),
        kind_of<Action, UserAction>(
            {.name = "user", .doc = "tells clients something ([event.wait](control-protocol.md))"},
            {entry_by<&UserAction::data>({.name = "data",
                                          .type = "any",
                                          .doc = "any JSON up to 4096 bytes",
                                          .fallback = "null",
                                          .schema = R"({"description": "Any JSON, up to 4096 bytes."})"},
                                         read_user_data)})};
    CHECK(kinds.size() == std::variant_size_v<Action>);
    return kinds;
}

Result<Action> read_action(const json& value, const std::string& path) {
    return read_whole_kind(action_kinds(), value, path, "action");
}

}  // namespace

const std::vector<Kind<Trigger>>& trigger_kinds() {
    static const std::vector<Kind<Trigger>> kinds = make_triggers();
    return kinds;
}

const std::vector<Kind<Action>>& action_kinds() {
    static const std::vector<Kind<Action>> kinds = make_actions();
    return kinds;
}

FieldOf<EventSpec> actions_field() {
    return list_at<&EventSpec::actions>(
        {.name = "do",
         .doc = "actions, done in this order; at most 64",
         .fallback = "[]",
         .schema = R"({"type": "array", "items": {"$ref": "#/$defs/action"}, "maxItems": 64})"},
        max_event_actions, read_action);
}

FieldTable<EventSpec> fields_of(std::type_identity<EventSpec>) {
    static const std::vector<FieldOf<EventSpec>> table{
        name_at<&EventSpec::name>({.name = "name", .doc = "unique among events", .required = true}),
        nested_at<&EventSpec::when>({.name = "when",
                                     .doc = "one trigger: what makes it fire",
                                     .required = true,
                                     .schema = R"({"$ref": "#/$defs/trigger"})"},
                                    read_trigger),
        actions_field(),
        field_at<&EventSpec::limit>(
            {.name = "limit", .doc = "how often it fires at most; 0: any number", .range = {.low = 0.0}})};
    return table;
}

std::string_view type_name(const Trigger& trigger) {
    constexpr std::string_view names[] = {"at_s", "every_s", "border", "meet", "event", "arrived"};
    static_assert(std::size(names) == std::variant_size_v<Trigger>);
    if (const auto* border = std::get_if<AtBorder>(&trigger)) return border->enters ? "enter" : "leave";
    return names[trigger.index()];
}

FieldTable<EventReport> fields_of(std::type_identity<EventReport>) {
    using Report = EventReport;
    static const std::vector<FieldOf<Report>> table{
        told_at<&Report::name>({.name = "name", .doc = "its name"}),
        told_at<&Report::when>({.name = "when", .doc = "the kind of its trigger"}),
        told_at<&Report::fired>({.name = "fired", .doc = "how often it has fired"}),
        told_at<&Report::limit>({.name = "limit", .doc = "how often it fires at most; 0: any number"})};
    return table;
}

Result<EventSpec> read_event(JsonReader& reader) {
    return read_all<EventSpec>(reader);
}

}  // namespace camrig::world
