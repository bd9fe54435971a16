#include "core/world/shipped.h"

#include <algorithm>
#include <cstdlib>
#include <system_error>

#include "core/world/scene_names.h"

namespace camrig::world {

namespace fs = std::filesystem;

namespace {

/// Tells a folder of scenes from any other of that name.
constexpr const char* mark = "schema.json";
constexpr std::size_t max_shipped_files = 10000;

bool is_word(const std::string& text) {
    return !text.empty() && std::ranges::all_of(text, [](unsigned char c) {
        return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == '-';
    });
}

/// Models below the shipped folder, by what they are called in scene files.
std::map<std::string, fs::path> shipped_models(const fs::path& folder) {
    std::map<std::string, fs::path> models;
    std::error_code problem;
    std::size_t seen = 0;
    for (fs::recursive_directory_iterator each(folder, problem), end; !problem && each != end;
         each.increment(problem)) {
        if (++seen > max_shipped_files) break;
        fs::path name = each->path().lexically_relative(folder);
        if (name.extension() == ".glb") models.emplace(name.replace_extension().generic_string(), each->path());
    }
    return models;
}

}  // namespace

bool leads_below(std::string_view text) {
    const fs::path path(text);
    return !text.empty() && text.find('\0') == std::string_view::npos && path.is_relative() &&
           std::ranges::none_of(path, [](const fs::path& part) { return part == ".."; });
}

fs::path shipped_folder() {
    if (const char* given = std::getenv("CAMRIG_SCENES"); given != nullptr && *given != '\0') return given;
    std::error_code problem;
    const fs::path program = fs::read_symlink("/proc/self/exe", problem);
    if (problem) return {};
    const fs::path installed = (program.parent_path() / "../share/camrig/scenes").lexically_normal();
    if (fs::exists(installed / mark, problem)) return installed;
    for (fs::path folder = program.parent_path(); folder.has_relative_path(); folder = folder.parent_path())
        if (fs::exists(folder / "scenes" / mark, problem)) return folder / "scenes";
    return {};
}

std::map<std::string, fs::path> shipped_scenes() {
    std::map<std::string, fs::path> scenes;
    std::error_code problem;
    const fs::path folder = shipped_folder();
    for (fs::directory_iterator each(folder, problem), end; !problem && each != end; each.increment(problem)) {
        const fs::path& file = each->path();
        if (file.extension() == ".json" && file.filename() != mark) scenes.emplace(file.stem().string(), file);
    }
    return scenes;
}

Result<fs::path> find_shipped_scene(std::string_view name) {
    const auto scenes = shipped_scenes();
    if (const auto found = scenes.find(std::string(name)); found != scenes.end()) return found->second;
    return error(ErrorKind::not_found, std::string(name.substr(0, 80)) +
                                           ": no scene of this name comes with the program; there are: " +
                                           known_names(scenes) + "; else give a scene file (.json, .gltf or .glb)");
}

Result<fs::path> find_scene(const fs::path& scene) {
    if (!is_word(scene.string())) return scene;
    return find_shipped_scene(scene.string());
}

Result<fs::path> find_shipped_model(std::string_view name) {
    fs::path file(name);
    if (!leads_below(name))
        return error(ErrorKind::invalid_argument, "after camrig: comes the name of a shipped model, as people/anna");
    if (!file.has_extension()) file += ".glb";
    const fs::path folder = shipped_folder();
    std::error_code problem;
    if (!folder.empty() && fs::is_regular_file(folder / file, problem)) return folder / file;
    return error(ErrorKind::not_found, "no shipped model '" + std::string(name.substr(0, 80)) +
                                           "'; there are: " + known_names(shipped_models(folder)));
}

}  // namespace camrig::world
