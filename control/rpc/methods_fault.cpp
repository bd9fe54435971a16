#include "control/rpc/method_fields.h"
#include "control/rpc/methods.h"
#include "core/world/read/fault_json.h"

namespace camrig::control {
namespace {

using nlohmann::json;

json fault_json(const engine::FaultReply& reply) {
    const fault::Fault& fault = *reply.fault;
    return {{"id", fault.id},
            {"camera", reply.camera},
            {"kind", fault::name_of(fault.kind)},
            {"layer", to_string(fault::layer_of(fault.kind))},
            {"start_ns", fault.begin_ns},
            {"end_ns", fault.end_ns == max_time_ns ? json(nullptr) : json(fault.end_ns)},
            {"severity", fault.severity},
            {"seed", fault.seed},
            {"params", fault::params_of(fault.kind)}};
}

std::vector<Field> fault_result() {
    return {{"id", "integer", "of this fault, unique in the rig"},
            {"camera", "string", "that fails"},
            {"kind", "string", "what goes wrong"},
            {"layer", "string", "where: body, optics, sensor, driver or transport; faults act in this order"},
            {"start_ns", "integer", "world time from which on it is there", false, "ns"},
            {.name = "end_ns",
             .type = "integer or null",
             .doc = "world time at which it is over",
             .unit = "ns",
             .null = "when it is cleared"},
            {"severity", "number", "0 to 1"},
            {"seed", "integer", "of what is random in it"},
            {"params", "object", "of that kind, all of them"}};
}

json set_json(const engine::FaultReply& reply) {
    json value = fault_json(reply);
    value["applied_ns"] = reply.applied_ns;
    return value;
}

template <auto member>
auto asked_camera() {
    auto field = camera_name_at<member>("camera");
    field.field.required = false;
    field.field.fallback = "all cameras";
    field.read = world::entry_by<member>(field.field, [](JsonReader& reader, std::string_view key, std::string& out) {
                     reader.required(key, out);
                 }).read;
    return field;
}

std::vector<FieldOf<engine::SetFault>> set_table() {
    std::vector<FieldOf<engine::SetFault>> table{camera_name_at<&engine::SetFault::camera>("camera")};
    world::add_inner<&engine::SetFault::fault>(table, world::timed_fault_fields());
    return table;
}

std::vector<FieldOf<engine::ClearFaults>> clear_table() {
    return {field_at<&engine::ClearFaults::id>(
                {.name = "id", .doc = "of one fault", .fallback = "all that are meant", .range = {.low = 1}}),
            asked_camera<&engine::ClearFaults::camera>(),
            world::entry_by<&engine::ClearFaults::kind>({.name = "kind",
                                                         .type = "string",
                                                         .doc = "those of this kind",
                                                         .fallback = "every kind",
                                                         .choices = world::fault_names()},
                                                        world::read_fault_name)};
}

std::vector<FieldOf<engine::GetReaderLog>> log_table() {
    return {field_at<&engine::GetReaderLog::since>(
                {.name = "since", .doc = "number of the last event that is known", .fallback = "0"}),
            asked_camera<&engine::GetReaderLog::camera>()};
}

std::vector<FieldOf<stream::ReaderEvent>> reader_event_table() {
    using Event = stream::ReaderEvent;
    return {field_at<&Event::number>({.name = "number", .doc = "counts from 1"}),
            field_at<&Event::kind>(
                {.name = "kind",
                 .doc = "closed: from now on who comes is refused, or finds no device; open: not any more, its server "
                        "or device is there again; refused: somebody came and was; thrown_out: a reader was; good: a "
                        "reader was given a frame without faults, its first or the first after one that had some"}),
            field_at<&Event::camera>({.name = "camera", .doc = "its name"}),
            field_at<&Event::output>({.name = "output", .doc = "of which kind: mjpeg, rtsp, device or v4l2"}),
            field_at<&Event::peer>({.name = "peer",
                                    .doc = "who, as in the books (stats.get): of all readers of an RTSP stream its "
                                           "path; of closed and open empty"}),
            field_at<&Event::world_ns>({.name = "world_ns",
                                        .doc = "world time of the frame that was given or kept back; of refused, of "
                                               "the rig's newest instant",
                                        .unit = "ns"}),
            field_at<&Event::monotonic_ns>(
                {.name = "monotonic_ns", .doc = "when it happened, CLOCK_MONOTONIC", .unit = "ns"}),
            field_at<&Event::real_ns>({.name = "real_ns", .doc = "the same since 1970, CLOCK_REALTIME", .unit = "ns"})};
}

json readers_json(const stream::ReaderLog::Since& log) {
    json events = json::array();
    for (const stream::ReaderEvent& one : log.events) events.push_back(write_fields(reader_event_table(), one));
    return {{"events", std::move(events)}, {"last", log.last}, {"missed", log.missed}};
}

std::vector<FieldOf<engine::ClearFaults>> wipe_table() {
    return {camera_name_at<&engine::ClearFaults::camera>("camera")};
}

json cleared_json(const engine::ClearFaults::Reply& reply) {
    return {{"cleared", reply.cleared}, {"applied_ns", reply.applied_ns}};
}

void check_clear(const engine::ClearFaults& command, JsonReader& reader) {
    if (!command.id && command.camera.empty())
        reader.fail({ErrorKind::invalid_argument, "give id or camera: which faults are to be cleared"});
}

}  // namespace

std::vector<Method> fault_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::ListFaults>> list{asked_camera<&engine::ListFaults::camera>()};
    const std::vector<Field> cleared_result{{"cleared", "integer", "how many"},
                                            {"applied_ns", "integer", "world time from which it shows", false, "ns"}};
    auto set_result = fault_result();
    set_result.push_back({"applied_ns", "integer", "world time of the first frame that it may act on", false, "ns"});
    return {
        {.name = "fault.set",
         .summary = "Lets a camera fail, as docs/faults.md says. Acts on frames that fall due from now on; several "
                    "faults act together. world.load clears all.",
         .params = descriptions_of(set_table()),
         .result = set_result,
         .errors = {invalid_argument, not_found, unsupported, resource_exhausted},
         .handler = handler_of(context, set_table(), set_json),
         .example = R"({"camera": "lobby", "kind": "drop", "start_s": 12, "end_s": 15.5, "severity": 0.6, )"
                    R"("params": {"burst_frames": 8}})"},
        {.name = "fault.clear",
         .summary = "Ends one fault, or those of a camera.",
         .params = descriptions_of(clear_table()),
         .result = cleared_result,
         .errors = {invalid_argument, not_found},
         .handler = handler_of(
             context, [](JsonReader& reader) { return read_all(clear_table(), reader, check_clear); }, cleared_json),
         .example = R"({"camera": "lobby"})"},
        {.name = "fault.wipe",
         .summary = "Wipes the glass before a camera's lens, as its wiper does when ONVIF's tt:Wiper|On tells it: ends "
                    "dirt, drops and condensation.",
         .params = descriptions_of(wipe_table()),
         .result = cleared_result,
         .errors = {invalid_argument, not_found},
         .handler = handler_of(
             context,
             [](JsonReader& reader) {
                 auto command = read_all(wipe_table(), reader);
                 if (command) command->by_wiper = true;
                 return command;
             },
             cleared_json),
         .example = R"({"camera": "lobby"})"},
        {.name = "fault.list",
         .summary = "The faults that are not over.",
         .params = descriptions_of(list),
         .result = {{"faults", "array of objects", "each as fault.set answers it, without applied_ns"},
                    {"world_ns", "integer", "world time", false, "ns"}},
         .errors = {not_found},
         .handler = handler_of(context, list,
                               [](const engine::ListFaults::Reply& reply) -> json {
                                   json faults = json::array();
                                   for (const auto& one : reply.faults) faults.push_back(fault_json(one));
                                   return {{"faults", std::move(faults)}, {"world_ns", reply.world_ns}};
                               }),
         .only_looks = true},
        {.name = "fault.log",
         .summary = "What faults let readers meet, oldest first: when who was refused or thrown out, when a server or "
                    "device was there again, and when a reader had its first good frame, by which the time is "
                    "measured that it takes to come back. Begin with 0 and go on with `last`. The rig keeps the "
                    "newest 4096.",
         .params = descriptions_of(log_table()),
         .result = {{.name = "events",
                     .type = "array of objects",
                     .doc = "each number, kind, camera, output, peer, world_ns, monotonic_ns, real_ns",
                     .parts = descriptions_of(reader_event_table()),
                     .shape = "ReaderEvent"},
                    {"last", "integer", "number of the newest event of all cameras"},
                    {"missed", "integer", "events after `since`, of all cameras, that are not kept any more"}},
         .errors = {invalid_argument, not_found},
         .handler = handler_of(context, log_table(), readers_json),
         .example = R"({"camera": "lobby", "since": 0})",
         .only_looks = true},
    };
}

}  // namespace camrig::control
