#include <filesystem>
#include <memory>

#include <CLI/CLI.hpp>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {

namespace fs = std::filesystem;

void add_view_command(CLI::App& app, CliContext& context, const CliHooks& hooks) {
    struct Options {
        fs::path file = "cameras.json";
        int width = 1280;
        int height = 800;
    };
    auto options = std::make_shared<Options>();
    CLI::App* view =
        app.add_subcommand("view", "a window on the running world: fly through it, place cameras by mouse");
    view->add_option("--file", options->file, "where the arrangement is saved, for camera create --file FILE --replace")
        ->capture_default_str();
    view->add_option("--width", options->width, "of the window, in pixels")
        ->check(CLI::Range(800, 8192))
        ->capture_default_str();
    view->add_option("--height", options->height, "of the window, in pixels")
        ->check(CLI::Range(480, 8192))
        ->capture_default_str();
    view->callback([options, &context, &hooks] {
        context.action = [options, &context, &hooks] {
            return hooks.view({context.control, context.token_file.string(), options->file.string(),
                               std::to_string(options->width), std::to_string(options->height)});
        };
    });
}

}  // namespace camrig::cli
