#include "tools/camrig/cli.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <ostream>
#include <utility>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/outputs.h"
#include "tools/camrig/version.h"

namespace camrig::cli {
namespace {

/// How many letters have to be changed, added or left out to make one word of the other (Levenshtein 1966).
std::size_t edit_distance(std::string_view from, std::string_view to) {
    std::vector<std::size_t> row(to.size() + 1);
    std::iota(row.begin(), row.end(), 0);
    for (std::size_t i = 0; i < from.size(); ++i) {
        std::size_t diagonal = std::exchange(row[0], i + 1);
        for (std::size_t j = 0; j < to.size(); ++j) {
            const std::size_t replaced = diagonal + (from[i] == to[j] ? 0 : 1);
            diagonal = row[j + 1];
            row[j + 1] = std::min({replaced, row[j] + 1, diagonal + 1});
        }
    }
    return row.back();
}

/// Whether a word may be meant by one that is not known: its beginning, or the same but for every third letter.
bool may_mean(std::string_view typed, std::string_view known) {
    return typed.size() > 2 && (known.starts_with(typed) || edit_distance(typed, known) <= typed.size() / 3);
}

/// "; did you mean a, b?"
std::string did_you_mean(const std::vector<std::string>& similar) {
    std::string words;
    for (const std::string& each : similar) words += (words.empty() ? "" : ", ") + each;
    return words.empty() ? "" : "; did you mean " + words + "?";
}

/// The command that was given, and its words: "camera create".
std::pair<const CLI::App*, std::string> command_of(const CLI::App& app) {
    const CLI::App* innermost = &app;
    std::string words;
    while (!innermost->get_subcommands().empty()) {
        innermost = innermost->get_subcommands().front();
        words += (words.empty() ? "" : " ") + innermost->get_name();
    }
    return {innermost, words.empty() ? app.get_name() : words};
}

/// "A subcommand is required" does not say which word was none; this does, and lists those that are.
std::string unknown_command(const CLI::App& app) {
    const auto [innermost, given] = command_of(app);
    const auto words = app.remaining(true);
    const auto word = std::ranges::find_if(words, [](const std::string& each) { return !each.starts_with('-'); });
    std::string commands;
    std::vector<std::string> similar;
    for (const CLI::App* command : innermost->get_subcommands([](const CLI::App*) { return true; })) {
        commands += (commands.empty() ? "" : ", ") + command->get_name();
        if (word != words.end() && may_mean(*word, command->get_name())) similar.push_back(command->get_name());
    }
    const std::string problem = word == words.end() ? given + ": a command is missing" : "no command '" + *word + "'";
    return problem + did_you_mean(similar) + "; there are " + commands;
}

/// A word that belongs nowhere, and the options that may be meant by it.
std::string unexpected_word(const CLI::App& app) {
    const auto [innermost, command] = command_of(app);
    const auto words = app.remaining(true);
    const auto option = std::ranges::find_if(words, [](const std::string& each) { return each.starts_with("-"); });
    if (option == words.end())
        return command + ": '" + (words.empty() ? "" : words.front()) + "' is one word more than it takes";
    const std::string name = option->substr(0, option->find('='));
    if (command == "exec") return "exec: no option " + name + " of its own; the program and its options come after --";
    std::vector<std::string> similar;
    for (const CLI::App* each = innermost; each; each = each->get_parent())
        for (const CLI::Option* known : each->get_options())
            for (const std::string& known_name : known->get_lnames())
                if (may_mean(name, "--" + known_name)) similar.push_back("--" + known_name);
    return command + ": no option " + name + did_you_mean(similar);
}

/// What CLI11 says of a wrong value, in the words of the other messages; what is put otherwise stays as it is.
std::string wrong_value(const CLI::ParseError& problem) {
    const std::string text = problem.what();
    const auto parts = [&](std::string_view first, std::string_view second) {
        const std::size_t a = text.find(first), b = text.rfind(second);
        if (a == std::string::npos || b == std::string::npos || b < a + first.size())
            return std::array<std::string, 3>{};
        return std::array{text.substr(0, a), text.substr(a + first.size(), b - a - first.size()),
                          text.substr(b + second.size())};
    };
    if (const auto [before, option, given] = parts("Could not convert: ", " = "); !option.empty())
        return option + ": expected a number, got '" + given + "'";
    if (const auto [option, given, type] = parts(": Failed parsing ", " as a "); !option.empty())
        return option + ": expected a number, got '" + given + "'";
    if (const auto [option, given, range] = parts(": Value ", " not in range "); !option.empty())
        return option + ": must be a number from " + range + ", got '" + given + "'";
    if (const auto [option, count, type] = parts(": ", " required "); !option.empty() && type.ends_with(" missing"))
        return option + ": its value is missing";
    return text;
}

}  // namespace

int run_cli(std::vector<std::string> arguments, const CliHooks& hooks) {
    register_outputs();
    CliContext context{.out = hooks.out, .err = hooks.err};
    CLI::App app("camrig: a rig of virtual cameras that programs take for real ones", "camrig");
    app.require_subcommand(1);
    app.fallthrough();
    app.set_version_flag("--version", std::string("camrig ") + version);
    app.add_flag("--json", context.json, "machine-readable output");
    app.add_option("--control", context.control,
                   "the rig's control socket: a path, or HOST:PORT with --tcp; default $CAMRIG_CONTROL, "
                   "$XDG_RUNTIME_DIR/camrig.sock, /tmp/camrig-$UID.sock");
    app.add_option("--token-file", context.token_file, "file with the token, for whatever is not loopback");

    add_serve_command(app, context, hooks);
    add_check_command(app, context);
    add_camera_commands(app, context);
    add_ptz_commands(app, context);
    add_fault_commands(app, context, hooks);
    add_world_commands(app, context);
    add_actor_commands(app, context);
    add_object_commands(app, context);
    add_event_commands(app, context);
    add_snapshot_command(app, context);
    add_truth_command(app, context);
    add_record_command(app, context);
    add_stats_command(app, context);
    add_exec_command(app, context, hooks);
    add_probe_command(app, context);
    add_sensor_command(app, context);
    add_bake_command(app, context);
    add_plate_commands(app, context);
    add_view_command(app, context, hooks);
    add_protocol_commands(app, context);
    add_python_command(app, context, hooks, "ros2", "camrig.ros2",
                       "files for ROS 2 camera drivers, and rosbag2 recordings, without ROS");
    add_python_command(app, context, hooks, "farm", "camrig.farm",
                       "many machines: data sets by a plan of shards, each drawn exactly once in effect");
    add_python_command(app, context, hooks, "randomize", "camrig.randomize",
                       "light and people's clothes by chance, of a seed");
    add_manual_commands(app, context);
    app.add_subcommand("version", "prints the version")->callback([&] {
        context.action = [&] { return context.print({{"version", version}}, std::string("camrig ") + version); };
    });

    // Where the words cannot be understood CLI11 sets no option, and how to say so must be known.
    const auto own_end = std::ranges::find(arguments, "--");
    context.json = std::find(arguments.begin(), own_end, "--json") != own_end;
    std::ranges::reverse(arguments);  // CLI11 takes them from the back
    try {
        app.parse(std::move(arguments));
        return context.action();
    } catch (const CLI::ParseError& problem) {
        // Help and version are "errors" of CLI11 that print and succeed.
        if (problem.get_exit_code() == 0) return app.exit(problem, hooks.out, hooks.err);
        if (problem.get_name() == "RequiredError" && std::string_view(problem.what()).starts_with("A subcommand"))
            return context.usage(unknown_command(app));
        // Its name is that of the command, not of the error.
        if (problem.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError))
            return context.usage(unexpected_word(app) + " (camrig --help, camrig COMMAND --help)");
        return context.usage(wrong_value(problem) + " (camrig --help, camrig COMMAND --help)");
    } catch (const nlohmann::json::exception& problem) {
        return context.fail(unexpected_answer(problem));
    } catch (const std::exception& problem) {
        return context.fail({ErrorKind::internal, problem.what()});
    }
}

}  // namespace camrig::cli
