#include <memory>

#include <CLI/CLI.hpp>

#include "tools/bake/bake_command.h"
#include "tools/camrig/cli_commands.h"
#include "tools/camrig/companion_program.h"

namespace camrig::cli {

void add_bake_command(CLI::App& app, CliContext& context) {
    auto options = std::make_shared<BakeCommand>();
    CLI::App* bake = app.add_subcommand(
        "bake", "finds where light goes among what stands still in a scene, for pictures of quality beautiful");
    options->add_options(*bake);
    bake->callback(
        [options, &context] { context.action = [options] { return exec_companion(bake_program, options->words()); }; });
}

}  // namespace camrig::cli
