#pragma once

#include <memory>

#include "core/render/scene/prepared_model.h"

namespace camrig::render::software {
struct SoftwareModel;
}
namespace camrig::render {

/// What renderers make of models and may share, on whatever threads they are: with textures most of a world's memory.
/// Empty: each renderer has its own.
struct SharedModels {
    std::shared_ptr<scene::PreparedModels> prepared{};
    std::shared_ptr<scene::ModelCache<software::SoftwareModel>> software{};
};
SharedModels make_shared_models();

}  // namespace camrig::render
