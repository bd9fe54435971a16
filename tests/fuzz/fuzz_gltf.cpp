// Any bytes as a model file: an error or a model that can be posed and drawn, never a crash.
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/world/gltf_loader.h"
#include "core/world/model_scene.h"
#include "core/world/posed_model.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace camrig;
    const auto model = load_model(std::as_bytes(std::span(data, size)), {}, "fuzz");
    if (!model) return 0;
    (void)scene_of_model(*model);
    PosedModel pose;
    for (std::size_t a = 0; a < (*model)->animations.size() && a < 4; ++a) {
        const ClipState clip{.animation = static_cast<int>(a), .phase_ns = (*model)->animations[a].duration_ns / 3};
        pose_model(**model, std::span(&clip, 1), pose);
    }
    return 0;
}
