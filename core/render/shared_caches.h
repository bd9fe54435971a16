#pragma once

#include <memory>

#include "core/render/scene/prepared_model.h"

namespace camrig::render::software {
class BakedPictures;
class HandedLayers;
class LensViews;
struct SoftwareModel;
}  // namespace camrig::render::software
namespace camrig::render {

/// What renderers may share, on whatever threads they are: what they make of models, with textures most of a world's
/// memory, and of lenses; and layers that one hands over to another. Empty: each renderer has its own.
struct SharedCaches {
    std::shared_ptr<scene::PreparedModels> prepared{};
    std::shared_ptr<scene::ModelCache<software::SoftwareModel>> software{};
    std::shared_ptr<software::BakedPictures> baked{};
    std::shared_ptr<software::LensViews> lenses{};
    std::shared_ptr<software::HandedLayers> layers{};
};
SharedCaches make_shared_caches();

}  // namespace camrig::render
