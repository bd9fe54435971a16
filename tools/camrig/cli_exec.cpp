#include <memory>

#include <CLI/CLI.hpp>

#include "control/client/endpoint.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {

void add_exec_command(CLI::App& app, CliContext& context, const CliHooks& hooks) {
    auto command = std::make_shared<std::vector<std::string>>();
    CLI::App* exec = app.add_subcommand("exec", "runs a program that sees the rig's cameras as /dev/videoN");
    exec->add_option("COMMAND", *command, "after --: the program and its arguments")->required();
    exec->callback([command, &context, &hooks] {
        context.action = [command, &context, &hooks] {
            const std::string control = context.control.empty() ? client::default_control() : context.control;
            if (const auto at = client::Endpoint::parse(control); !at || !at->host.empty())
                return context.usage(
                    "--control: devices are those of a rig on this machine; give the path of its "
                    "socket, and no address as " +
                    control);
            return hooks.exec(*command, control);
        };
    });
}

}  // namespace camrig::cli
