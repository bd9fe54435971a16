#include <memory>

#include <CLI/CLI.hpp>

#include "core/base/json_reader.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

constexpr std::size_t max_option_bytes = std::size_t{1} << 20;

/// An option that takes JSON: a behaviour, a trigger, actions.
struct JsonOption {
    const char* key;
    std::string text = {};

    Result<void> put(json& params) const {
        if (text.empty()) return {};
        auto value = parse_json(text, max_option_bytes);
        if (!value) return at(std::string("--") + key, value.error());
        params[key] = std::move(*value);
        return {};
    }
};

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

/// `spawn` and `set`: what both take.
struct ActorOptions {
    std::string name, model, object_class, position, play;
    std::optional<double> yaw_deg, scale;
    JsonOption behaviour{"behaviour"}, attach{"attach"};

    void add_to(CLI::App& command) {
        command.add_option("NAME", name, "the actor")->required();
        command.add_option("--position", position, "X,Y,Z in metres");
        command.add_option("--yaw-deg", yaw_deg, "where it looks, counter-clockwise from +x");
        command.add_option("--behaviour", behaviour.text, "JSON, as in a scene file");
        command.add_option("--attach", attach.text, "JSON: {\"actor\": NAME, \"node\": NODE}");
    }
    Result<json> params() const {
        json params{{"name", name}};
        if (!model.empty()) params["model"] = model;
        if (!object_class.empty()) params["class"] = object_class;
        if (!position.empty()) {
            auto numbers = parse_numbers("--position", position, 3);
            if (!numbers) return numbers;
            params["position"] = std::move(*numbers);
        }
        if (yaw_deg) params["yaw_deg"] = *yaw_deg;
        if (scale) params["scale"] = *scale;
        if (!play.empty()) params["play"] = play == "none" ? "" : play;
        for (const JsonOption* option : {&behaviour, &attach})
            if (auto good = option->put(params); !good) return std::unexpected(good.error());
        return params;
    }
};

void add_actor_change(CLI::App& group, CliContext& context, bool spawns) {
    auto options = std::make_shared<ActorOptions>();
    CLI::App* command = spawns ? group.add_subcommand("spawn", "puts an actor into the world")
                               : group.add_subcommand("set", "changes an actor; what is not given stays");
    options->add_to(*command);
    if (spawns) {
        command->add_option("--model", options->model, "a model of the scene")->required();
        command->add_option("--class", options->object_class, "what ground truth calls it");
        command->add_option("--scale", options->scale, "of the model");
    } else {
        command->add_option("--play", options->play, "a clip over that of its behaviour; none: no longer");
    }
    command->callback([options, spawns, &context] {
        context.action = [options, spawns, &context] {
            auto params = options->params();
            if (!params) return context.usage(params.error().message);
            auto actor = context.call(spawns ? "actor.spawn" : "actor.set", *params);
            return actor ? context.print(*actor, actor_words(*actor)) : context.fail(actor.error());
        };
    });
}

/// One actor at a time; programs that steer many speak to the socket.
void add_steer(CLI::App& group, CliContext& context) {
    struct Options {
        std::string name, velocity, position, clip;
        std::optional<double> seconds, yaw_deg;
    };
    auto options = std::make_shared<Options>();
    CLI::App* steer = group.add_subcommand("steer", "moves an actor by hand; it keeps its velocity until told another");
    steer->add_option("NAME", options->name, "the actor")->required();
    auto* velocity = steer->add_option("--velocity", options->velocity, "X,Y,Z in m/s");
    auto* position = steer->add_option("--position", options->position, "X,Y,Z in metres")->excludes(velocity);
    steer->add_option("--seconds", options->seconds, "until it is at the position; by default at once")
        ->needs(position);
    steer->add_option("--yaw-deg", options->yaw_deg, "where it looks; by default the way it moves");
    steer->add_option("--clip", options->clip, "that it plays");
    steer->callback([options, &context] {
        context.action = [options, &context] {
            json actor{{"name", options->name}};
            for (const auto& [key, text] :
                 {std::pair{"velocity", options->velocity}, {"position", options->position}}) {
                if (text.empty()) continue;
                auto numbers = parse_numbers(std::string("--") + key, text, 3);
                if (!numbers) return context.usage(numbers.error().message);
                actor[key] = std::move(*numbers);
            }
            if (options->seconds) actor["seconds"] = *options->seconds;
            if (options->yaw_deg) actor["yaw_deg"] = *options->yaw_deg;
            if (!options->clip.empty()) actor["clip"] = options->clip;
            auto applied = context.call("actor.steer", {{"actors", json::array({actor})}});
            return applied ? context.print(*applied, options->name + ": steered, shown from world time " +
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
    struct Options {
        std::string name;
        JsonOption when{"when"}, actions{"do"};
        std::optional<int> limit;
    };
    auto options = std::make_shared<Options>();
    CLI::App* add = group.add_subcommand("add", "adds an event");
    add->add_option("NAME", options->name, "its name")->required();
    add->add_option("--when", options->when.text, "JSON: what makes it fire, e.g. {\"at_s\": 30}")->required();
    add->add_option("--do", options->actions.text, "JSON: a list of what happens then");
    add->add_option("--limit", options->limit, "how often it fires at most");
    add->callback([options, &context] {
        context.action = [options, &context] {
            json params{{"name", options->name}};
            for (const JsonOption* option : {&options->when, &options->actions})
                if (auto good = option->put(params); !good) return context.usage(good.error().message);
            if (options->limit) params["limit"] = *options->limit;
            auto event = context.call("event.add", params);
            return event ? context.print(*event, options->name + ": waits from world time " +
                                                     seconds_text((*event).at("applied_ns")))
                         : context.fail(event.error());
        };
    });
}

void add_event_wait(CLI::App& group, CliContext& context) {
    struct Options {
        std::uint64_t since = 0;
        double timeout_s = 10.0;
    };
    auto options = std::make_shared<Options>();
    CLI::App* wait = group.add_subcommand("wait", "shows the events that have fired; waits for one");
    wait->add_option("--since", options->since, "number of the last event that is known")->capture_default_str();
    wait->add_option("--timeout", options->timeout_s, "longest wait, in seconds")
        ->check(CLI::Range(0.0, 300.0))
        ->capture_default_str();
    wait->callback([options, &context] {
        context.action = [options, &context] {
            const auto patience = std::chrono::seconds(static_cast<int>(options->timeout_s) + 20);
            auto log =
                context.call("event.wait", {{"since", options->since}, {"timeout_s", options->timeout_s}}, patience);
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
    add_remove(*group, context, "event.remove");
    add_event_wait(*group, context);
}

}  // namespace camrig::cli
