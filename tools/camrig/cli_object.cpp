#include <memory>
#include <optional>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

using nlohmann::json;

std::string place_words(const json& object) {
    const json& at = object.at("position");
    return plain_text(at[0]) + "," + plain_text(at[1]) + "," + plain_text(at[2]);
}

int list_objects(const CliContext& context) {
    auto answer = context.call("object.list");
    if (!answer) return context.fail(answer.error());
    std::vector<std::vector<std::string>> rows{{"NAME", "CLASS", "MODEL", "POSITION", "MOVES", "HIDDEN"}};
    for (const json& object : (*answer).at("objects"))
        rows.push_back({plain_text(object.at("name")), plain_text(object.at("class")), plain_text(object.at("model")),
                        place_words(object), object.at("moves") ? "yes" : "", object.at("hidden") ? "yes" : ""});
    return context.print(*answer, table(rows, 3));
}

/// get and remove.
void add_by_name(CLI::App& group, CliContext& context, const char* verb, const std::string& method, const char* help) {
    auto name = std::make_shared<std::string>();
    CLI::App* command = group.add_subcommand(verb, help);
    command->add_option("NAME", *name, "of the object")->required();
    command->callback([name, method, &context] {
        context.action = [name, method, &context] {
            auto answer = context.call(method, {{"name", *name}});
            if (!answer) return context.fail(answer.error());
            const bool is_told = (*answer).contains("position");
            return context.print(*answer, *name + (is_told ? ": at " + place_words(*answer) : ": removed"));
        };
    });
}

/// spawn and set.
void add_change(CLI::App& group, CliContext& context, bool spawns) {
    struct Options {
        std::string name;
        std::optional<std::string> model, object_class;
        std::vector<double> position;
        std::optional<double> yaw_deg, scale;
        bool hidden = false, shown = false;
    };
    auto options = std::make_shared<Options>();
    CLI::App* command =
        spawns ? group.add_subcommand("spawn", "puts an object into the world, which stands where it is")
               : group.add_subcommand("set", "hides, shows, scales an object or an actor, or moves an object");
    command->add_option("NAME", options->name, "of the object")->required();
    if (spawns) {
        command->add_option("--model", options->model, "a model of the scene")->required();
        command->add_option("--class", options->object_class, "what ground truth calls it");
    } else {
        auto* hidden = command->add_flag("--hidden", options->hidden, "in no picture and no ground truth");
        command->add_flag("--shown", options->shown, "seen again")->excludes(hidden);
    }
    command->add_option("--position", options->position, "X,Y,Z of its origin")->delimiter(',')->expected(3);
    command->add_option("--yaw-deg", options->yaw_deg, "counter-clockwise from above");
    command->add_option("--scale", options->scale, "of the model");
    command->callback([options, spawns, &context] {
        context.action = [options, spawns, &context] {
            json params{{"name", options->name}};
            if (options->model) params["model"] = *options->model;
            if (options->object_class) params["class"] = *options->object_class;
            if (!options->position.empty()) params["position"] = options->position;
            if (options->yaw_deg) params["yaw_deg"] = *options->yaw_deg;
            if (options->scale) params["scale"] = *options->scale;
            if (options->hidden || options->shown) params["hidden"] = options->hidden;
            auto object = context.call(spawns ? "object.spawn" : "object.set", params);
            if (!object) return context.fail(object.error());
            return context.print(*object, options->name + ": at " + place_words(*object) + ", shown from world time " +
                                              seconds_text((*object).at("applied_ns")));
        };
    });
}

}  // namespace

void add_object_commands(CLI::App& app, CliContext& context) {
    CLI::App* group = app.add_subcommand("object", "shows, puts in, hides, changes and removes objects");
    group->require_subcommand(1);
    group->add_subcommand("list", "all objects, and actors")->callback([&context] {
        context.action = [&context] { return list_objects(context); };
    });
    add_by_name(*group, context, "get", "object.get", "one of them, with its box (--json)");
    add_change(*group, context, true);
    add_change(*group, context, false);
    add_by_name(*group, context, "remove", "object.remove", "takes it out of the world");
}

}  // namespace camrig::cli
