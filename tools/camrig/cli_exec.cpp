#include <memory>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {

void add_exec_command(CLI::App& app, CliContext& context, const CliHooks& hooks) {
    auto command = std::make_shared<std::vector<std::string>>();
    CLI::App* exec = app.add_subcommand("exec", "runs a program that sees the rig's cameras as /dev/videoN");
    exec->add_option("COMMAND", *command, "after --: the program and its arguments")->required();
    exec->callback([command, &context, &hooks] {
        context.action = [command, &context, &hooks] {
            return hooks.exec(*command, context.control.empty() ? client::default_control() : context.control);
        };
    });
}

}  // namespace camrig::cli
