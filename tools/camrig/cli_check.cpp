#include <memory>

#include <CLI/CLI.hpp>

#include "control/rpc/methods.h"
#include "tools/camrig/cli_commands.h"

namespace camrig::cli {
namespace {

int check(const CliContext& context, const std::filesystem::path& scene) {
    const world::SceneCheck found = world::check_scene(scene);
    const std::string file = found.file.string();
    std::string words;
    for (const PlacedError& each : found.errors)
        words += file + ": " + (each.path.empty() ? "" : each.path + ": ") + each.message + "\n";
    if (found.left_out > 0) words += file + ": and " + std::to_string(found.left_out) + " errors more\n";
    if (found.errors.empty()) return context.print(control::to_json(found), file + ": good");
    context.json ? static_cast<void>(context.print(control::to_json(found), ""))
                 : static_cast<void>(context.err << words);
    return exit_failed;
}

}  // namespace

void add_check_command(CLI::App& app, CliContext& context) {
    auto scene = std::make_shared<std::filesystem::path>();
    CLI::App* command = app.add_subcommand("check", "reads a scene without a rig and tells all of its errors");
    command->add_option("SCENE", *scene, scene_option_help)->required();
    command->callback([scene, &context] { context.action = [scene, &context] { return check(context, *scene); }; });
}

}  // namespace camrig::cli
