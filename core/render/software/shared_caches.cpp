#include "core/render/shared_caches.h"

#include "core/render/software/baked_picture.h"
#include "core/render/software/handed_layers.h"
#include "core/render/software/lens_views.h"
#include "core/render/software/software_model.h"

namespace camrig::render {

SharedCaches make_shared_caches() {
    return {.prepared = std::make_shared<scene::PreparedModels>(),
            .software = std::make_shared<scene::ModelCache<software::SoftwareModel>>(),
            .baked = std::make_shared<software::BakedPictures>(),
            .lenses = std::make_shared<software::LensViews>(),
            .layers = std::make_shared<software::HandedLayers>()};
}

}  // namespace camrig::render
