#include <memory>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/cli_field_options.h"

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
    const std::string method = spawns ? "object.spawn" : "object.set";
    CLI::App* command =
        spawns ? group.add_subcommand("spawn", "puts an object into the world, which stands where it is")
               : group.add_subcommand("set", "hides, shows, scales an object or an actor, or moves an object");
    const MethodParams params = make_params();
    add_field_options(*command, params, params_of(method));
    if (!spawns) {
        const auto show = [params](std::int64_t) { (*params)["hidden"] = false; };
        command->add_flag_function("--shown", show, "seen again")->excludes(command->get_option("--hidden"));
    }
    command->callback([params, method, &context] {
        context.action = [params, method, &context] {
            auto object = context.call(method, *params);
            if (!object) return context.fail(object.error());
            return context.print(*object, plain_text(params->at("name")) + ": at " + place_words(*object) +
                                              ", shown from world time " + seconds_text((*object).at("applied_ns")));
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
