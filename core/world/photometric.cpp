#include "core/world/photometric.h"

#include <numbers>

#include "core/world/daylit.h"

namespace camrig::world {

std::optional<double> unit_lux(const Environment& environment) {
    if (environment.lux) return environment.lux;
    return environment.daylight ? std::optional(daylight_lux) : std::nullopt;
}

ModelRef in_scene_units(const Model& model, double lux) {
    auto made = std::make_shared<Model>(model);
    const auto scale = static_cast<float>(std::numbers::pi / lux);
    for (Material& material : made->materials) material.emissive *= scale;
    // Of lights of models the scene takes a pi-th (append_model_lights).
    for (ModelLight& light : made->lights) light.intensity *= scale;
    return made;
}

}  // namespace camrig::world
