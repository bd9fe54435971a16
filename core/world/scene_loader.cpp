#include <algorithm>
#include <new>

#include "core/world/baked/baked_light_file.h"
#include "core/world/gltf_loader.h"
#include "core/world/model_scene.h"
#include "core/world/scene_base.h"
#include "core/world/scene_check.h"
#include "core/world/scene_reader.h"
#include "core/world/shipped.h"

namespace camrig::world {
namespace {

Result<Scene> load_scene_file(const std::filesystem::path& file) {
    auto document = read_scene_document(file);
    if (!document) return std::unexpected(document.error());
    auto whole = on_its_base(std::move(*document), file);
    if (!whole) return std::unexpected(whole.error());
    const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
    auto scene =
        read_scene(whole->document, folder, [](const std::filesystem::path& model) { return load_model(model); });
    if (scene) scene->bases = std::move(whole->bases);
    return scene;
}

Result<Scene> load_any(const std::filesystem::path& file, const SceneOptions& options) {
    std::string extension = file.extension().string();
    std::ranges::transform(extension, extension.begin(), [](unsigned char c) { return std::tolower(c); });
    if (extension == ".json") {
        auto scene = load_scene_file(file);
        if (!scene) return at(file.string(), scene.error());
        return scene;
    }
    if (extension == ".gltf" || extension == ".glb") {
        auto model = load_model(file);
        if (!model) return std::unexpected(model.error());
        auto scene = scene_of_model(*model, options);
        if (!scene) return at(file.string(), scene.error());
        return scene;
    }
    return error(ErrorKind::invalid_argument, file.string() + ": is no scene; scenes are .json, .gltf or .glb files");
}

}  // namespace

SceneCheck check_scene(const std::filesystem::path& given) {
    SceneCheck check;
    check.file = find_scene(given).value_or(given);
    ErrorList errors;
    auto scene = load_scene(given);
    if (scene) {
        check.scene = std::move(*scene);
    } else if (errors.all().empty()) {
        // It ended before its parts were read.
        const std::string file = check.file.string() + ": ";
        std::string message = scene.error().message;
        if (message.starts_with(file)) message.erase(0, file.size());
        errors.add("", message);
    }
    check.errors = errors.all();
    check.left_out = errors.left_out();
    return check;
}

Result<SceneRef> load_scene(const std::filesystem::path& given, const SceneOptions& options) {
    try {
        const auto file = find_scene(given);
        if (!file) return std::unexpected(file.error());
        auto scene = load_any(*file, options);
        if (!scene) return std::unexpected(scene.error());
        scene->file = *file;
        if (options.baked_light) {
            const ErrorList::Pause another_file;
            find_baked_light(*scene, *file);
        }
        return std::make_shared<const Scene>(std::move(*scene));
    } catch (const std::bad_alloc&) {
        return error(ErrorKind::resource_exhausted, given.string() + ": not enough memory for this scene");
    } catch (const std::filesystem::filesystem_error& problem) {
        return error(ErrorKind::invalid_argument, problem.what());
    }
}

}  // namespace camrig::world
