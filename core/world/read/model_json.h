#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include "core/base/kind.h"
#include "core/world/scene.h"
#include "core/world/shape_model.h"

namespace camrig::world {

/// Finds the model that a scene names; load_model() outside tests.
using ModelSource = std::function<Result<ModelRef>(const std::filesystem::path& file)>;

/// An entry of `models` that names a file.
struct ModelFile {
    /// The axis of the file that points ahead.
    enum class Front : std::uint8_t { plus_x, minus_x, plus_z, minus_z };
    std::string file;
    Front front = Front::plus_z;
    bool photometric = false;  ///< see photometric.h
};
FieldTable<ModelFile> fields_of(std::type_identity<ModelFile>);
/// Entries that need none, by their `shape`. They have a front too.
const std::vector<Kind<Shape>>& shape_kinds();

/// Reads the entries of `models` of one scene file. Each model file is read once, whatever its names.
class ModelReader {
public:
    /// `folder`: of the scene file. Both must outlive the reader.
    ModelReader(const std::filesystem::path& folder, const ModelSource& source) : folder_(folder), source_(source) {}

    /// An entry: a file or a shape; errors carry the JSON path.
    Result<SceneModel> read(const nlohmann::json& value, const std::string& path);

private:
    Result<ModelRef> load(const std::string& file);

    const std::filesystem::path& folder_;
    const ModelSource& source_;
    std::map<std::string, ModelRef> loaded_;  ///< by file, as the scene writes it
};

}  // namespace camrig::world
