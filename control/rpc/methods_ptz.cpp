#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "core/world/camera_json.h"

namespace camrig::control {

namespace {

using nlohmann::json;

const std::vector<FieldOf<camera::PtzMove>>& move_table() {
    static const std::vector<FieldOf<camera::PtzMove>> table{
        field_at<&camera::PtzMove::mode>(
            {.name = "mode",
             .doc = "absolute: to these angles and this zoom; relative: by these angles, the zoom "
                    "by this factor; continuous: so many degrees a second, the zoom by this "
                    "share of its speed (-1 to 1), until another command, a limit or timeout_s; fov: what the "
                    "picture shows at x and y comes to its middle, through the lens, the zoom by this factor"}),
        field_at<&camera::PtzMove::pan_deg>({.name = "pan_deg",
                                             .doc = "positive is to the left",
                                             .unit = "deg",
                                             .fallback = "goes on as it does",
                                             .range = {-1e5, 1e5}}),
        field_at<&camera::PtzMove::tilt_deg>({.name = "tilt_deg",
                                              .doc = "positive is upwards",
                                              .unit = "deg",
                                              .fallback = "goes on as it does",
                                              .range = {-1e5, 1e5}}),
        field_at<&camera::PtzMove::x>(
            {.name = "x", .doc = "of fov: to the right, in halves of the picture from its middle", .range = {-10, 10}}),
        field_at<&camera::PtzMove::y>(
            {.name = "y", .doc = "of fov: upwards, in halves of the picture", .range = {-10, 10}}),
        field_at<&camera::PtzMove::zoom>(
            {.name = "zoom", .doc = "of the focal length", .fallback = "goes on as it does", .range = {-1, 1000}}),
        field_at<&camera::PtzMove::speed>({.name = "speed",
                                           .doc = "share of the head's speed that pan and tilt do not exceed, nor the "
                                                  "zoom of absolute and relative moves",
                                           .range = {0.001, 1}}),
        world::seconds_at<&camera::PtzMove::timeout>({.name = "timeout_s",
                                                      .doc = "of a continuous move: it stops by itself",
                                                      .fallback = "until told otherwise",
                                                      .range = {0, 86'400},
                                                      .option = "timeout"})};
    return table;
}

template <typename C>
FieldOf<C> camera_field() {
    return camera_name_at<&C::camera>("camera");
}

json status_json(const engine::PtzReply& reply) {
    json value = world::ptz_to_json(reply.status);
    value["world_ns"] = reply.world_ns;
    value["arrives_ns"] = reply.arrives_ns;
    value["applied_ns"] = reply.applied_ns;
    value["presets"] = json::object();
    for (const auto& [name, position] : reply.presets) value["presets"][name] = world::ptz_to_json(position);
    value["tours"] = json::object();
    for (const auto& [name, stops] : reply.tours)
        for (const camera::PtzTourStop& stop : stops)
            value["tours"][name].push_back({{"preset", stop.preset},
                                            {"dwell_s", static_cast<double>(stop.dwell) / ns_per_s},
                                            {"speed", stop.speed}});
    value["tour"] = reply.tour ? json(*reply.tour) : json(nullptr);
    return value;
}

std::vector<Field> status_fields() {
    return {{"pan_deg", "number", "where the head believes to be, as its encoders tell", false, "deg"},
            {"tilt_deg", "number", "the same", false, "deg"},
            {"zoom", "number", "of the focal length"},
            {"turning", "boolean", "from the command on, its latency included, until it stands"},
            {"zooming", "boolean", "the same of the zoom"},
            {"true", "object", "pan_deg, tilt_deg and zoom where it truly is, which pictures show"},
            {"world_ns", "integer", "world time of all this", false, "ns"},
            {"arrives_ns", "integer", "world time from which it stands; 2^63 - 1: it never will", false, "ns"},
            {"applied_ns", "integer", "world time from which pictures show the last command", false, "ns"},
            {"presets", "object", "pan_deg, tilt_deg and zoom by name"},
            {"tours", "object", "arrays of {preset, dwell_s, speed} by name"},
            {"tour", "string or null", "the tour that it goes on with"}};
}

/// The camera, and the fields of the move.
const FieldOf<engine::MovePtz>& moved_camera() {
    static const auto field = camera_field<engine::MovePtz>();
    return field;
}

std::vector<Field> move_fields() {
    std::vector<Field> fields = descriptions_of(move_table());
    fields.insert(fields.begin(), moved_camera().field);
    return fields;
}

Result<engine::MovePtz> read_move(JsonReader& reader) {
    Changes<engine::MovePtz> named;
    moved_camera().read(reader, named);
    Changes<camera::PtzMove> changes;
    read_fields(move_table(), reader, changes);
    engine::MovePtz command;
    named.apply_to(command);
    changes.apply_to(command.move);
    const auto& move = command.move;
    const bool is_fov = move.mode == camera::PtzMode::fov;
    if (reader.ok() && !is_fov && (move.x || move.y))
        reader.fail(move.x ? "x" : "y", "is of mode fov; this one names pan_deg, tilt_deg or zoom, or more of them");
    if (reader.ok() && is_fov && (move.pan_deg || move.tilt_deg))
        reader.fail(move.pan_deg ? "pan_deg" : "tilt_deg", "is of the other modes; fov names x, y or zoom");
    if (reader.ok() && !move.pan_deg && !move.tilt_deg && !move.zoom && !move.x && !move.y)
        reader.fail(is_fov ? "x" : "pan_deg",
                    is_fov ? "is missing; a move by fov names x, y or zoom, or more of them"
                           : "is missing; a move names pan_deg, tilt_deg or zoom, or more of them");
    if (reader.ok() && move.timeout && move.mode != camera::PtzMode::continuous)
        reader.fail("timeout_s", "is of continuous moves; this one ends where it goes to");
    if (reader.ok() && command.move.zoom) {
        const bool is_share = command.move.mode == camera::PtzMode::continuous;
        const double zoom = *command.move.zoom;
        if (is_share && zoom > 1.0) reader.fail("zoom", "must be -1 to 1 in a continuous move");
        if (!is_share && zoom <= 0.0) reader.fail("zoom", "must be over 0 in this mode");
    }
    if (auto finished = reader.finish(); !finished) return std::unexpected(finished.error());
    return command;
}

template <auto member>
auto preset_name_at() {
    return field_at<member>(
        {.name = "preset", .doc = "name of the preset", .required = true, .range = {.low = 1, .high = 64}});
}

/// A method whose command reads `table` and has this action.
template <typename C>
Method action_method(RpcContext& context, const char* name, const char* summary, std::vector<FieldOf<C>> table,
                     typename C::Action action, const char* example) {
    using enum ErrorKind;
    return {.name = name,
            .summary = summary,
            .params = descriptions_of(table),
            .result = status_fields(),
            .errors = {invalid_argument, not_found, unsupported, resource_exhausted},
            .handler = handler_of(
                context,
                [table, action](JsonReader& reader) {
                    auto command = read_all(table, reader);
                    if (command) command->action = action;
                    return command;
                },
                status_json),
            .example = example};
}

/// A method about a preset (or home), which is what the command's action says.
Method preset_method(RpcContext& context, const char* name, const char* summary, engine::PtzPresets::Action action,
                     const char* example) {
    const bool is_home =
        action == engine::PtzPresets::Action::set_home || action == engine::PtzPresets::Action::go_home;
    std::vector<FieldOf<engine::PtzPresets>> table{camera_field<engine::PtzPresets>()};
    if (!is_home) table.push_back(preset_name_at<&engine::PtzPresets::preset>());
    return action_method(context, name, summary, std::move(table), action, example);
}

const std::vector<FieldOf<camera::PtzTourStop>>& stop_table() {
    static const std::vector<FieldOf<camera::PtzTourStop>> table{
        preset_name_at<&camera::PtzTourStop::preset>(),
        world::seconds_at<&camera::PtzTourStop::dwell>({.name = "dwell_s",
                                                        .doc = "that it stands there",
                                                        .fallback = "5",
                                                        .range = {0.1, 86'400},
                                                        .option = "dwell"}),
        field_at<&camera::PtzTourStop::speed>(
            {.name = "speed", .doc = "share of the head's speed on the way to it", .range = {0.001, 1}})};
    return table;
}

/// A method about a tour, which is what the command's action says.
Method tour_method(RpcContext& context, const char* name, const char* summary, engine::PtzTours::Action action,
                   const char* example) {
    std::vector<FieldOf<engine::PtzTours>> table{
        camera_field<engine::PtzTours>(),
        field_at<&engine::PtzTours::tour>(
            {.name = "tour", .doc = "name of the tour", .required = true, .range = {.low = 1, .high = 64}})};
    if (action == engine::PtzTours::Action::set)
        table.push_back(world::list_at<&engine::PtzTours::stops>(
            {.name = "stops",
             .doc = "1 to 64, each {preset, dwell_s, speed}; the first comes after the last",
             .required = true,
             .parts = descriptions_of(stop_table())},
            camera::PtzHead::max_tour_stops, [](const json& value, const std::string& path) {
                JsonReader reader(value, path);
                return read_all(stop_table(), reader);
            }));
    return action_method(context, name, summary, std::move(table), action, example);
}

}  // namespace

std::vector<Method> ptz_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::StopPtz>> stop{
        camera_field<engine::StopPtz>(),
        field_at<&engine::StopPtz::pan_tilt>({.name = "pan_tilt", .doc = "stops to turn"}),
        field_at<&engine::StopPtz::zoom>({.name = "zoom", .doc = "stops to zoom"})};
    const std::vector<FieldOf<engine::GetPtz>> asked{camera_field<engine::GetPtz>()};
    return {
        {.name = "ptz.move",
         .summary = "Turns and zooms the head of a camera (camera field ptz). Answers at once; the motion begins after "
                    "the head's latency and takes the place of what the axes named here do. Pan and tilt arrive "
                    "together. An absolute move beyond the limits is an error; the others end there.",
         .params = move_fields(),
         .result = status_fields(),
         .errors = {invalid_argument, not_found, unsupported, resource_exhausted},
         .handler = handler_of(context, read_move, status_json),
         .example = R"({"camera": "lobby", "pan_deg": 30, "tilt_deg": -10, "zoom": 2})"},
        {.name = "ptz.stop",
         .summary = "Brakes.",
         .params = descriptions_of(stop),
         .result = status_fields(),
         .errors = {invalid_argument, not_found, unsupported, resource_exhausted},
         .handler = handler_of(context, stop, status_json),
         .example = R"({"camera": "lobby"})"},
        {.name = "ptz.status",
         .summary = "Where the head is now, what it believes, whether it moves, its presets.",
         .params = descriptions_of(asked),
         .result = status_fields(),
         .errors = {invalid_argument, not_found, unsupported},
         .handler = handler_of(context, asked, status_json),
         .example = R"({"camera": "lobby"})",
         .only_looks = true},
        preset_method(context, "ptz.preset_set", "Remembers where the head believes to be, 256 places at most.",
                      engine::PtzPresets::Action::set, R"({"camera": "lobby", "preset": "door"})"),
        preset_method(context, "ptz.preset_goto", "Goes to a preset as an absolute move does.",
                      engine::PtzPresets::Action::go_to, R"({"camera": "lobby", "preset": "door"})"),
        preset_method(context, "ptz.preset_remove", "Forgets a preset.", engine::PtzPresets::Action::remove,
                      R"({"camera": "lobby", "preset": "door"})"),
        preset_method(context, "ptz.home_set", "Makes where the head believes to be its home.",
                      engine::PtzPresets::Action::set_home, R"({"camera": "lobby"})"),
        preset_method(context, "ptz.home_goto", "Goes home, as an absolute move does; at first that is pan and tilt 0.",
                      engine::PtzPresets::Action::go_home, R"({"camera": "lobby"})"),
        tour_method(context, "ptz.tour_set", "Makes a guard tour of presets, 16 tours at most.",
                    engine::PtzTours::Action::set,
                    R"({"camera": "lobby", "tour": "round", "stops": [{"preset": "door"}, {"preset": "desk", )"
                    R"("dwell_s": 10, "speed": 0.3}]})"),
        tour_method(context, "ptz.tour_start",
                    "Goes from stop to stop, over and over, until any command that moves the head or stops it. Presets "
                    "count as they are when it starts.",
                    engine::PtzTours::Action::start, R"({"camera": "lobby", "tour": "round"})"),
        tour_method(context, "ptz.tour_remove", "Forgets a tour; one that goes on is not stopped.",
                    engine::PtzTours::Action::remove, R"({"camera": "lobby", "tour": "round"})"),
    };
}

}  // namespace camrig::control
