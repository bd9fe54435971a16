#include "tools/camrig/cli_view.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <memory>
#include <system_error>

#include <CLI/CLI.hpp>
#include <unistd.h>

#include "tools/camrig/cli_commands.h"

namespace camrig::cli {

namespace fs = std::filesystem;

namespace {

constexpr const char* program_name = "camrig-view";

std::string find_view() {
    if (const char* given = std::getenv("CAMRIG_VIEW"); given != nullptr && *given != '\0') return given;
    std::error_code problem;
    const fs::path folder = fs::read_symlink("/proc/self/exe", problem).parent_path();
    for (const fs::path& place : {folder / program_name, folder / ".." / "lib" / "camrig" / program_name,
                                  folder / ".." / "view" / program_name})
        if (fs::exists(place, problem)) return fs::weakly_canonical(place, problem).string();
    return {};
}

}  // namespace

int exec_view(const std::vector<std::string>& arguments) {
    const std::string program = find_view();
    if (program.empty()) {
        std::fprintf(stderr,
                     "camrig: view: this camrig was built without its window (Debian: libglfw3-dev libimgui-dev); "
                     "the web page of the rig can do much of the same\n");
        return exit_failed;
    }
    std::vector<char*> words{const_cast<char*>(program_name)};
    for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
    words.push_back(nullptr);
    ::execv(program.c_str(), words.data());
    std::fprintf(stderr, "camrig: view: %s: %s\n", program.c_str(), std::strerror(errno));
    return exit_failed;
}

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
