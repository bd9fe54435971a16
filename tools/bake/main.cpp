#include <atomic>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <string>

#include <unistd.h>

#include "core/base/write_file.h"
#include "core/world/baked/baked_light_file.h"
#include "tools/bake/bake_command.h"

/// `camrig bake`: the light of a scene into a file beside it.
namespace {

namespace fs = std::filesystem;
namespace world = camrig::world;

std::atomic<bool> is_ended = false;

/// One line that is written over, on a terminal; elsewhere a line for each tenth.
class ProgressLine {
public:
    bool operator()(double done) {
        using std::chrono::steady_clock;
        const double seconds = std::chrono::duration<double>(steady_clock::now() - begin_).count();
        const double left = done > 0.01 ? seconds * (1.0 - done) / done : 0.0;
        const int shown = static_cast<int>(done * (is_terminal_ ? 1000 : 10));
        if (shown != shown_) {
            shown_ = shown;
            std::fprintf(stderr, "%s%5.1f %% after %.0f s, %.0f s to go%s", is_terminal_ ? "\r" : "", 100.0 * done,
                         seconds, left, is_terminal_ ? "   " : "\n");
            std::fflush(stderr);
        }
        return !is_ended;
    }
    void end() const {
        if (is_terminal_ && shown_ >= 0) std::fputc('\n', stderr);
    }

private:
    bool is_terminal_ = ::isatty(2) == 1;
    int shown_ = -1;
    std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};

int fail(const std::string& message) {
    std::fprintf(stderr, "camrig: bake: %s\n", message.c_str());
    return 1;
}

/// Whether the file has light of the scene as it is.
int check(const world::Scene& scene, const fs::path& file) {
    const auto light = world::read_baked_light(file, scene);
    if (!light) return fail(file.string() + ": " + light.error().message);
    std::printf("%s: up to date\n", file.c_str());
    return 0;
}

}  // namespace

int main(int argc, char** argv) {
    CLI::App app{"finds where light goes among what stands still in a scene"};
    app.name("camrig bake");
    camrig::cli::BakeCommand command;
    command.add_options(app);
    CLI11_PARSE(app, argc, argv);

    world::SceneOptions without;
    without.baked_light = false;
    const auto scene = world::load_scene(command.scene, without);
    if (!scene) return fail(scene.error().message);
    const auto files = world::baked_light_files(**scene, (*scene)->file);
    if (command.checks && command.out.empty() && !files.empty()) command.out = files.front();
    if (command.out.empty()) command.out = fs::path((*scene)->file).replace_extension(world::baked_light_ending);
    if (command.checks) return check(**scene, command.out);
    // Before hours of work: its folder takes files.
    const fs::path folder = command.out.has_parent_path() ? command.out.parent_path() : fs::path(".");
    if (::access(folder.c_str(), W_OK | X_OK) != 0)
        return fail(folder.string() + ": cannot be written to (" + std::strerror(errno) +
                    "); give -o FILE, and put it beside a copy of the scene");
    std::signal(SIGINT, [](int) { is_ended = true; });
    std::signal(SIGTERM, [](int) { is_ended = true; });
    // Ended by Ctrl-C, or by the machine: the next time it goes on from its last bounce.
    command.options.checkpoint = command.out;
    command.options.checkpoint += ".part";
    ProgressLine progress;
    command.options.progress = std::ref(progress);
    const auto light = camrig::bake::bake(*scene, command.options);
    progress.end();
    if (!light) return fail((*scene)->file.string() + ": " + light.error().message);
    const std::vector<std::byte> bytes = world::encode_baked_light(*light);
    if (auto written = camrig::write_atomically(command.out, bytes); !written) return fail(written.error().message);
    std::error_code ignored;
    fs::remove(command.options.checkpoint, ignored);
    std::printf("%s: %.1f MB, a map of %d x %d texels in %zu layers, %zu probes, %zu for reflections\n",
                command.out.c_str(), static_cast<double>(bytes.size()) / 1e6, light->size.width, light->size.height,
                light->layers.size(), light->grid.size(), light->reflection_probes.places.size());
    return 0;
}
