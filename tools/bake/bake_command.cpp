#include "tools/bake/bake_command.h"

#include <algorithm>
#include <sstream>
#include <thread>

#include "core/world/baked/baked_light_header.h"

namespace camrig::cli {

BakeCommand::BakeCommand() {
    options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
}

void BakeCommand::add_options(CLI::App& app) {
    app.add_option("SCENE", scene, "name of a shipped scene, or a file")->required();
    app.add_option("-o,--out", out, "file to write (default: beside the scene's, with the ending .light)");
    app.add_flag("--check", checks, "bake nothing: say whether the light beside the scene is up to date");
    app.add_option("--texels-per-m", options.texels_per_m, "of the map; fewer where it would be too large")
        ->capture_default_str()
        ->check(CLI::Range(0.1, 1000.0));
    app.add_option("--max-side", options.max_side, "of the map, in texels")
        ->capture_default_str()
        ->check(CLI::Range(64, world::max_light_map_side));
    app.add_option("--rays", options.rays, "for each texel; four times as many halve the noise")
        ->capture_default_str()
        ->check(CLI::Range(16, 65536));
    app.add_option("--bounces", options.bounces, "of light before the last, at most")
        ->capture_default_str()
        ->check(CLI::Range(0, 64));
    app.add_option("--probe-spacing", options.probe_spacing_m,
                   "metres between the places that moving things take their light from")
        ->capture_default_str()
        ->check(CLI::Range(0.05, 1000.0));
    app.add_option("--reflections", options.reflections,
                   "places that mirroring surfaces see their surroundings from, at most; fewer where less mirrors")
        ->capture_default_str()
        ->check(CLI::Range(std::size_t{0}, world::max_reflection_probes));
    app.add_option("--threads", options.threads, "the light is the same with any number")
        ->capture_default_str()
        ->check(CLI::Range(1, 256));
}

std::vector<std::string> BakeCommand::words() const {
    const auto text = [](double value) {
        std::ostringstream out_text;
        out_text.precision(17);
        out_text << value;
        return out_text.str();
    };
    std::vector<std::string> made{scene.string(),
                                  "--texels-per-m",
                                  text(options.texels_per_m),
                                  "--max-side",
                                  std::to_string(options.max_side),
                                  "--rays",
                                  std::to_string(options.rays),
                                  "--bounces",
                                  std::to_string(options.bounces),
                                  "--probe-spacing",
                                  text(options.probe_spacing_m),
                                  "--reflections",
                                  std::to_string(options.reflections),
                                  "--threads",
                                  std::to_string(options.threads)};
    if (!out.empty()) made.insert(made.end(), {"--out", out.string()});
    if (checks) made.emplace_back("--check");
    return made;
}

}  // namespace camrig::cli
