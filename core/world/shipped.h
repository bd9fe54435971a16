#pragma once

#include <filesystem>
#include <map>
#include <string>
#include <string_view>

#include "core/base/result.h"

/// The scenes and models that come with the program. They lie in one folder: $CAMRIG_SCENES, else
/// ../share/camrig/scenes beside the program (installed), else scenes/ of the source checkout that the program is in.
namespace camrig::world {

/// What a scene file writes before the name of a shipped model: "camrig:people/anna".
inline constexpr std::string_view shipped_prefix = "camrig:";

/// Whether a path of a scene file stays in the folder it is put behind, and is a path: holds no NUL.
bool leads_below(std::string_view text);

/// Empty: there is none.
std::filesystem::path shipped_folder();

/// By name.
std::map<std::string, std::filesystem::path> shipped_scenes();

/// The file of one. Error not_found for a name that none has, with those that are.
Result<std::filesystem::path> find_shipped_scene(std::string_view name);

/// What SCENE means, on the command line and in methods: a word of letters, digits, _ and - is a shipped scene,
/// whatever lies in the working folder; all else is a path, and a file of such a name is ./NAME. Error not_found for a
/// word that is none, with those that are.
Result<std::filesystem::path> find_scene(const std::filesystem::path& scene);

/// The file of "camrig:NAME": below the shipped folder, ".glb" where the name has no ending. Errors: invalid_argument
/// for a name that leads elsewhere, not_found with those that are.
Result<std::filesystem::path> find_shipped_model(std::string_view name);

}  // namespace camrig::world
