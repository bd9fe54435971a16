#include "tools/camrig/cli.h"

#include <algorithm>
#include <ostream>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/outputs.h"
#include "tools/camrig/version.h"

namespace camrig::cli {
namespace {

/// "A subcommand is required" does not say which word was none; this does, and lists those that are.
std::string unknown_command(const CLI::App& app) {
    const CLI::App* innermost = &app;
    while (!innermost->get_subcommands().empty()) innermost = innermost->get_subcommands().front();
    std::string commands;
    for (const CLI::App* command : innermost->get_subcommands([](const CLI::App*) { return true; }))
        commands += (commands.empty() ? "" : ", ") + command->get_name();
    const auto words = app.remaining(true);
    const auto word = std::ranges::find_if(words, [](const std::string& each) { return !each.starts_with('-'); });
    const std::string problem =
        word == words.end() ? innermost->get_name() + ": a command is missing" : "no command '" + *word + "'";
    return problem + "; there are " + commands;
}

/// A word that belongs nowhere, and the options that it may be the beginning of.
std::string unexpected_word(const CLI::App& app) {
    const CLI::App* innermost = &app;
    while (!innermost->get_subcommands().empty()) innermost = innermost->get_subcommands().front();
    const auto words = app.remaining(true);
    const auto option = std::ranges::find_if(words, [](const std::string& each) { return each.starts_with("-"); });
    const std::string command = innermost == &app ? "camrig" : innermost->get_name();
    if (option == words.end())
        return command + ": '" + (words.empty() ? "" : words.front()) + "' is one word more than it takes";
    const std::string name = option->substr(0, option->find('='));
    std::string similar;
    for (const CLI::App* each = innermost; each; each = each->get_parent())
        for (const CLI::Option* known : each->get_options())
            for (const std::string& known_name : known->get_lnames())
                if (("--" + known_name).starts_with(name)) similar += (similar.empty() ? "--" : ", --") + known_name;
    return command + ": no option " + name +
           (similar.empty() || name.size() < 3 ? "" : "; did you mean " + similar + "?");
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
        return context.usage(std::string(problem.what()) + " (camrig --help, camrig COMMAND --help)");
    } catch (const nlohmann::json::exception& problem) {
        return context.fail(unexpected_answer(problem));
    } catch (const std::exception& problem) {
        return context.fail({ErrorKind::internal, problem.what()});
    }
}

}  // namespace camrig::cli
