#include "control/rpc/method_fields.h"
#include "core/world/read/event_json.h"
#include "core/world/world_fields.h"

namespace camrig::control {

namespace {

using nlohmann::json;

constexpr double longest_wait_s = 300.0;

json record_json(const world::EventRecord& record) {
    json data = json::array();
    for (const std::string& text : record.data) data.push_back(json::parse(text, nullptr, false));
    return {{"sequence", record.sequence}, {"event", record.event},   {"world_ns", record.world_ns},
            {"actor", record.actor},       {"data", std::move(data)}, {"errors", record.errors}};
}

json log_json(const engine::EventLog& log) {
    json events = json::array();
    for (const world::EventRecord& record : log.events) events.push_back(record_json(record));
    return {{"events", std::move(events)}, {"last", log.last}, {"missed", log.missed}};
}

Result<engine::AddEvent> read_added(JsonReader& reader) {
    auto event = world::read_event(reader);
    if (!event) return std::unexpected(event.error());
    return engine::AddEvent{std::move(*event)};
}

}  // namespace

std::vector<Method> event_methods(RpcContext& context) {
    using enum ErrorKind;
    const std::vector<FieldOf<engine::WaitEvents>> wait{
        field_at<&engine::WaitEvents::since>({.name = "since", .doc = "number of the last event that is known"}),
        world::seconds_at<&engine::WaitEvents::timeout_ns>({.name = "timeout_s",
                                                            .doc = "longest wait; then the list is empty",
                                                            .fallback = "10",
                                                            .range = {0.0, longest_wait_s}})};
    FieldOf<world::EventSpec> actions = world::actions_field();
    actions.field.required = true;
    const auto read_act = [actions](JsonReader& reader) -> Result<engine::Act> {
        auto read = read_all(std::vector{actions}, reader);
        if (!read) return std::unexpected(read.error());
        return engine::Act{std::move(read->actions)};
    };
    return {
        {.name = "event.list",
         .summary = "All events, in the order they were added.",
         .params = {},
         .result = {{"events", "array of objects", "each name, when, fired and limit"}},
         .errors = {},
         .handler = handler_of<engine::ListEvents>(
             context,
             [](const std::vector<world::EventReport>& reports) { return json{{"events", list_json(reports)}}; }),
         .only_looks = true},
        {.name = "event.add",
         .summary = "Adds an event. The keys are those of an event in a scene file (docs/scene-format.md). Times count "
                    "from the loading of the scene.",
         .params = descriptions_of<world::EventSpec>(),
         .result = change_fields<world::EventReport>("world time from which it waits"),
         .errors = {invalid_argument, already_exists, not_found, resource_exhausted},
         .handler = handler_of(context, read_added, change_json<world::EventReport>),
         .example = R"({"name": "alarm", "when": {"every_s": 60}, "do": [{"action": "user", "data": {"level": 2}}]})"},
        {.name = "event.act",
         .summary =
             "Does at once what an event's actions do: switches a light, changes the surroundings, sends an actor "
             "somewhere. Where a name is unknown nothing is done; another error names the action, and those "
             "before it are done.",
         .params = {actions.field},
         .result = {{"applied_ns", "integer", "world time from which it shows", false, "ns"}},
         .errors = {invalid_argument, not_found, resource_exhausted},
         .handler = handler_of(context, read_act, applied_json),
         .example = R"({"do": [{"action": "environment", "daylight": {"azimuth_deg": 250, "elevation_deg": 8}}]})"},
        remove_method<engine::RemoveEvent>(context, "event", "Removes an event; what it has done stays.", "alarm"),
        {.name = "event.wait",
         .summary =
             "The events that have fired after number `since`, oldest first; waits for one when there is none. Begin "
             "with 0 and go on with `last`. Requests on one connection are answered in order, so who waits long "
             "takes a connection of its own. The rig keeps the newest 1024, and lets 256 clients wait: with one "
             "more the wait that is longest ends, with an empty list, if it is a second old.",
         .params = descriptions_of(wait),
         .result = {{.name = "events",
                     .type = "array of objects",
                     .doc = "each sequence, event (its name), world_ns, actor (who entered, left, met or arrived, else "
                            "empty), data (of its user actions) and errors (actions that could not be done)",
                     .parts = {{"sequence", "integer", "its number"},
                               {"event", "string", "its name"},
                               {"world_ns", "integer", "world time at which it fired", false, "ns"},
                               {"actor", "string", "who entered, left, met or arrived; else empty"},
                               {"data", "array", "of its user actions"},
                               {"errors", "array of strings", "actions that could not be done"}},
                     .shape = "FiredEvent"},
                    {"last", "integer", "number of the newest event of all"},
                    {"missed", "integer", "events after `since` that are not kept any more"}},
         .errors = {invalid_argument, resource_exhausted},
         .handler = handler_of(context, wait, log_json),
         .example = R"({"since": 0, "timeout_s": 0})",
         .only_looks = true},
    };
}

}  // namespace camrig::control
