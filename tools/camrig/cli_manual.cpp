#include <algorithm>
#include <memory>
#include <ostream>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"
#include "tools/camrig/manual.h"
#include "tools/camrig/version.h"

namespace camrig::cli {

void add_manual_commands(CLI::App& app, CliContext& context) {
    auto shell = std::make_shared<std::string>();
    CLI::App* completion = app.add_subcommand("completion", "prints what a shell loads to complete camrig's commands");
    completion->add_option("SHELL", *shell, "bash, zsh or fish")
        ->required()
        ->check(CLI::IsMember({"bash", "zsh", "fish"}));
    completion->callback([shell, &app, &context] {
        context.action = [shell, &app, &context] {
            context.out << completion_of(command_tree(app), *shell);
            return 0;
        };
    });

    auto wanted = std::make_shared<std::string>();
    CLI::App* manual = app.add_subcommand("manual", "prints a manual page in roff: camrig manual camera | man -l -");
    manual->add_option("COMMAND", *wanted, "a command; without: the page of the program");
    manual->callback([wanted, &app, &context] {
        context.action = [wanted, &app, &context] {
            const CommandNode tree = command_tree(app);
            if (wanted->empty()) {
                context.out << manual_of_program(tree, version);
                return 0;
            }
            const auto found = std::ranges::find(tree.commands, std::vector<std::string>{*wanted}, &CommandNode::words);
            if (found == tree.commands.end()) return context.usage("manual: no command '" + *wanted + "'");
            context.out << manual_of_command(tree, *found, version);
            return 0;
        };
    });
}

}  // namespace camrig::cli
