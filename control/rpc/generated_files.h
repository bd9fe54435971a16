#pragma once

#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/kind.h"
#include "core/base/result.h"

/// Files of the repository that are made from the tables of methods and parameters: `camrig methods --write .` makes
/// them, a unit test compares them.
namespace camrig::control {

struct GeneratedFile {
    std::string path;  ///< from the root of the repository
    /// Makes the file's text from the text it has now: of some files only a part is generated.
    std::function<Result<std::string>(const std::string& present)> make;
};
std::vector<GeneratedFile> generated_files();

/// One generator a source file.
Result<std::string> scene_schema(const std::string& present);
Result<std::string> scene_format_tables(const std::string& present);
std::string python_parameters();
std::string client_parameters();

/// What the generators know of a camera, and of what world.* methods answer.
std::vector<Field> camera_descriptions();
std::vector<Field> world_descriptions();
using ObjectDescription = std::pair<std::string, std::vector<Field>>;
/// What else methods take with a table of fields, by its name in scenes/schema.json.
std::vector<ObjectDescription> objects_of_methods();
/// That, and what only scene files have; "scene" is a whole one.
std::vector<ObjectDescription> objects_of_scenes();
/// And what comes in kinds.
struct KindsDescription {
    std::string name;  ///< of one of them: "behaviour"
    std::string key;   ///< whose value names the kind; empty: the key of that name is there
    std::vector<KindDescription> kinds;
};
std::vector<KindsDescription> kinds_of_methods();
std::vector<KindsDescription> kinds_of_scenes();
/// The types of objects in `fields`, innermost first, each once.
std::vector<Field> shapes_in(const std::vector<Field>& fields);

}  // namespace camrig::control
