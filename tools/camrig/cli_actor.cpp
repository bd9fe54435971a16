#include <memory>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/cli_field_options.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string vector_words(const json& numbers) {
    std::string text;
    for (const json& number : numbers) text += (text.empty() ? "" : ",") + plain_text(number);
    return text;
}

std::string actor_words(const json& actor) {
    return plain_text(actor.at("name")) + ": " + plain_text(actor.at("behaviour")) + " at " +
           vector_words(actor.at("position")) + ", shown from world time " + seconds_text(actor.at("applied_ns"));
}

int list_actors(const CliContext& context) {
    auto answer = context.call("actor.list");
    if (!answer) return context.fail(answer.error());
    std::vector<std::vector<std::string>> rows{{"NAME", "CLASS", "BEHAVIOUR", "CLIP", "POSITION", "YAW"}};
    for (const json& actor : (*answer).at("actors"))
        rows.push_back({plain_text(actor.at("name")), plain_text(actor.at("class")), plain_text(actor.at("behaviour")),
                        plain_text(actor.at("clip")), vector_words(actor.at("position")),
                        plain_text(actor.at("yaw_deg"))});
    return context.print(*answer, table(rows, 4));
}

int list_events(const CliContext& context) {
    auto answer = context.call("event.list");
    if (!answer) return context.fail(answer.error());
    std::vector<std::vector<std::string>> rows{{"NAME", "WHEN", "FIRED", "LIMIT"}};
    for (const json& event : (*answer).at("events"))
        rows.push_back({plain_text(event.at("name")), plain_text(event.at("when")), plain_text(event.at("fired")),
                        event.at("limit") == 0 ? "" : plain_text(event.at("limit"))});
    return context.print(*answer, table(rows, 2));
}

void add_actor_change(CLI::App& group, CliContext& context, bool spawns) {
    const std::string method = spawns ? "actor.spawn" : "actor.set";
    CLI::App* command = spawns ? group.add_subcommand("spawn", "puts an actor into the world")
                               : group.add_subcommand("set", "changes an actor; what is not given stays");
    const MethodParams params = make_params();
    add_field_options(*command, params, params_of(method));
    command->callback([params, method, &context] {
        context.action = [params, method, &context] {
            // Easier to type than an empty word.
            if (params->value("play", "") == "none") (*params)["play"] = "";
            auto actor = context.call(method, *params);
            return actor ? context.print(*actor, actor_words(*actor)) : context.fail(actor.error());
        };
    });
}

/// One actor at a time; programs that steer many speak to the socket.
void add_steer(CLI::App& group, CliContext& context) {
    CLI::App* steer = group.add_subcommand("steer", "moves an actor by hand; it keeps its velocity until told another");
    const MethodParams actor = make_params();
    add_field_options(*steer, actor, params_of("actor.steer").front().parts);
    CLI::Option* const position = steer->get_option("--position")->excludes(steer->get_option("--velocity"));
    steer->get_option("--seconds")->needs(position);
    steer->callback([actor, &context] {
        context.action = [actor, &context] {
            if (actor->size() == 1)  // its name
                return context.fail(
                    {ErrorKind::invalid_argument, "say how: --velocity X,Y,Z (0,0,0: it stands) or --position X,Y,Z"});
            auto applied = context.call("actor.steer", {{"actors", json::array({*actor})}});
            return applied
                       ? context.print(*applied, plain_text(actor->at("name")) + ": steered, shown from world time " +
                                                     seconds_text((*applied).at("applied_ns")))
                       : context.fail(applied.error());
        };
    });
}

void add_remove(CLI::App& group, CliContext& context, const std::string& method) {
    auto name = std::make_shared<std::string>();
    CLI::App* remove = group.add_subcommand("remove", "removes it");
    remove->add_option("NAME", *name, "the " + method.substr(0, method.find('.')))->required();
    remove->callback([name, method, &context] {
        context.action = [name, method, &context] {
            auto gone = context.call(method, {{"name", *name}});
            return gone ? context.print(*gone, *name + ": removed") : context.fail(gone.error());
        };
    });
}

void add_event_add(CLI::App& group, CliContext& context) {
    CLI::App* add = group.add_subcommand("add", "adds an event");
    const MethodParams params = make_params();
    add_field_options(*add, params, params_of("event.add"));
    add->callback([params, &context] {
        context.action = [params, &context] {
            auto event = context.call("event.add", *params);
            return event ? context.print(*event, plain_text(params->at("name")) + ": waits from world time " +
                                                     seconds_text((*event).at("applied_ns")))
                         : context.fail(event.error());
        };
    });
}

void add_event_act(CLI::App& group, CliContext& context) {
    auto actions = std::make_shared<std::vector<std::string>>();
    CLI::App* act = group.add_subcommand("act", "does at once what an event's actions do");
    act->add_option("ACTION", *actions,
                    R"(as in `do` of an event: '{"action": "light", "light": "lamp", "intensity": 0}')")
        ->required();
    act->callback([actions, &context] {
        context.action = [actions, &context] {
            json list = json::array();
            for (const std::string& text : *actions) {
                auto action = parse_json(text, text.size());
                if (!action) return context.fail(at("ACTION", action.error()).error());
                list.push_back(std::move(*action));
            }
            auto done = context.call("event.act", {{"do", std::move(list)}});
            return done ? context.print(*done,
                                        "done; it shows from world time " + seconds_text((*done).at("applied_ns")))
                        : context.fail(done.error());
        };
    });
}

void add_event_wait(CLI::App& group, CliContext& context) {
    struct Options {
        std::uint64_t since = 0;
        double timeout_s = 10.0;
        bool is_new = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* wait = group.add_subcommand("wait", "shows the events that have fired; waits for one");
    auto* const since =
        wait->add_option("--since", options->since, "number of the last event that is known")->capture_default_str();
    wait->add_flag("--new", options->is_new, "only of what fires from now on")->excludes(since);
    wait->add_option("--timeout", options->timeout_s, "longest wait, in seconds")
        ->check(CLI::Range(0.0, 300.0))
        ->capture_default_str();
    wait->callback([options, &context] {
        context.action = [options, &context] {
            json last = options->since;
            if (options->is_new) {
                const auto before = context.call("event.wait", {{"timeout_s", 0}});
                if (!before) return context.fail(before.error());
                last = (*before).at("last");
            }
            const auto patience = std::chrono::seconds(static_cast<int>(options->timeout_s) + 20);
            const auto log = context.call("event.wait", {{"since", last}, {"timeout_s", options->timeout_s}}, patience);
            if (!log) return context.fail(log.error());
            std::vector<std::vector<std::string>> rows{{"NUMBER", "EVENT", "ACTOR", "DATA", "TIME"}};
            for (const json& event : (*log).at("events"))
                rows.push_back({plain_text(event.at("sequence")), plain_text(event.at("event")),
                                plain_text(event.at("actor")), event.at("data").empty() ? "" : event.at("data").dump(),
                                seconds_text(event.at("world_ns"))});
            return context.print(*log, table(rows, 4));
        };
    });
}

}  // namespace

void add_actor_commands(CLI::App& app, CliContext& context) {
    CLI::App* group = app.add_subcommand("actor", "shows, puts in, changes, steers and removes actors");
    group->require_subcommand(1);
    group->add_subcommand("list", "all actors")->callback([&context] {
        context.action = [&context] { return list_actors(context); };
    });
    add_actor_change(*group, context, true);
    add_actor_change(*group, context, false);
    add_steer(*group, context);
    add_remove(*group, context, "actor.remove");
}

void add_event_commands(CLI::App& app, CliContext& context) {
    CLI::App* group = app.add_subcommand("event", "shows, adds, removes and waits for events");
    group->require_subcommand(1);
    group->add_subcommand("list", "all events")->callback([&context] {
        context.action = [&context] { return list_events(context); };
    });
    add_event_add(*group, context);
    add_event_act(*group, context);
    add_remove(*group, context, "event.remove");
    add_event_wait(*group, context);
}

}  // namespace camrig::cli
