#include <cmath>

#include "control/rpc/methods.h"
#include "core/base/json_reader.h"
#include "core/world/read/event_json.h"
#include "core/world/read/json_parts.h"

namespace camrig {
namespace {

using nlohmann::json;

constexpr double longest_wait_s = 300.0;

json report_json(const EventReport& event) {
    return {{"name", event.name}, {"when", event.when}, {"fired", event.fired}, {"limit", event.limit}};
}

json record_json(const EventRecord& record) {
    json data = json::array();
    for (const std::string& text : record.data) data.push_back(json::parse(text, nullptr, false));
    return {{"sequence", record.sequence}, {"event", record.event},   {"world_ns", record.world_ns},
            {"actor", record.actor},       {"data", std::move(data)}, {"errors", record.errors}};
}

void add_event(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    auto event = read_event(reader);
    if (!event) return done(std::unexpected(event.error()));
    post(context, AddEvent{std::move(*event)}, std::move(done), [](const EventChange& change) {
        json value = report_json(change.event);
        value["applied_ns"] = change.applied_ns;
        return value;
    });
}

void remove_event(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    RemoveEvent command;
    required_name(reader, "name", command.name);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    post(context, std::move(command), std::move(done),
         [](const Applied& applied) { return json{{"applied_ns", applied.applied_ns}}; });
}

void wait_event(RpcContext& context, const json& params, RpcReply done) {
    JsonReader reader(params, "");
    WaitEvents command;
    double timeout_s = 10.0;
    reader.optional("since", command.since);
    optional_in_range(reader, "timeout_s", timeout_s, 0.0, longest_wait_s);
    if (auto finished = reader.finish(); !finished) return done(std::unexpected(finished.error()));
    command.timeout_ns = std::llround(timeout_s * 1e9);
    post(context, command, std::move(done), [](const EventLog& log) {
        json events = json::array();
        for (const EventRecord& record : log.events) events.push_back(record_json(record));
        return json{{"events", std::move(events)}, {"last", log.last}, {"missed", log.missed}};
    });
}

}  // namespace

std::vector<Method> event_methods(RpcContext& context) {
    using enum ErrorKind;
    const Field name{"name", "string", "name of the event", true};
    const std::vector<Field> report{{"name", "string", "its name"},
                                    {"when", "string", "the kind of its trigger"},
                                    {"fired", "integer", "how often it has fired"},
                                    {"limit", "integer", "how often it fires at most; 0: any number"},
                                    {"applied_ns", "integer", "world time from which it waits", false, "ns"}};
    return {
        {.name = "event.list",
         .summary = "All events, in the order they were added.",
         .params = {},
         .result = {{"events", "array of objects", "each name, when, fired and limit"}},
         .errors = {},
         .handler =
             [&context](const json&, RpcReply done) {
                 post(context, ListEvents{}, std::move(done), [](const std::vector<EventReport>& reports) {
                     json events = json::array();
                     for (const auto& event : reports) events.push_back(report_json(event));
                     return json{{"events", std::move(events)}};
                 });
             },
         .only_looks = true},
        {.name = "event.add",
         .summary = "Adds an event. The keys are those of an event in a scene file (docs/scene-format.md). Times count "
                    "from the loading of the scene.",
         .params = {name,
                    {"when", "object", "what makes it fire", true},
                    {"do", "array of objects", "what happens then, in this order; at most 64", false, "", "[]"},
                    {"limit", "integer", "how often it fires at most; 0: any number", false, "", "0"}},
         .result = report,
         .errors = {invalid_argument, already_exists, not_found, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { add_event(context, params, std::move(done)); },
         .example = R"({"name": "alarm", "when": {"every_s": 60}, "do": [{"action": "user", "data": {"level": 2}}]})"},
        {.name = "event.remove",
         .summary = "Removes an event; what it has done stays.",
         .params = {name},
         .result = {{"applied_ns", "integer", "world time from which it is gone", false, "ns"}},
         .errors = {invalid_argument, not_found},
         .handler = [&context](const json& params, RpcReply done) { remove_event(context, params, std::move(done)); },
         .example = R"({"name": "alarm"})"},
        {.name = "event.wait",
         .summary =
             "The events that have fired after number `since`, oldest first; waits for one when there is none. Begin "
             "with 0 and go on with `last`. Requests on one connection are answered in order, so who waits long "
             "takes a connection of its own. The rig keeps the newest 1024.",
         .params = {{"since", "integer", "number of the last event that is known", false, "", "0"},
                    {"timeout_s", "number", "longest wait, 0 to 300; then the list is empty", false, "s", "10"}},
         .result =
             {{"events", "array of objects",
               "each sequence, event (its name), world_ns, actor (who entered, left, met or arrived, else empty), "
               "data (of its user actions) and errors (actions that could not be done)"},
              {"last", "integer", "number of the newest event of all"},
              {"missed", "integer", "events after `since` that are not kept any more"}},
         .errors = {invalid_argument, resource_exhausted},
         .handler = [&context](const json& params, RpcReply done) { wait_event(context, params, std::move(done)); },
         .example = R"({"since": 0, "timeout_s": 0})",
         .only_looks = true},
    };
}

}  // namespace camrig
