#pragma once

#include <filesystem>
#include <functional>
#include <map>
#include <string>

#include <nlohmann/json.hpp>

#include "core/base/result.h"
#include "core/world/scene.h"

namespace camrig {

/// Finds the model that a scene names; load_model() outside tests.
using ModelSource = std::function<Result<ModelRef>(const std::filesystem::path& file)>;

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

}  // namespace camrig
