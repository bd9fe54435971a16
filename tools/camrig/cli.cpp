#include "tools/camrig/cli.h"

#include <algorithm>
#include <ostream>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/version.h"

namespace camrig {

int run_cli(std::vector<std::string> arguments, const CliHooks& hooks) {
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
    add_camera_commands(app, context);
    add_world_commands(app, context);
    add_snapshot_command(app, context);
    add_stats_command(app, context);
    add_exec_command(app, context, hooks);
    add_protocol_commands(app, context);
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
        return context.usage(std::string(problem.what()) + " (camrig --help, camrig COMMAND --help)");
    } catch (const std::exception& problem) {
        return context.fail({ErrorKind::internal, problem.what()});
    }
}

}  // namespace camrig
