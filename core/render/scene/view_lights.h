#pragma once

#include <glm/glm.hpp>

#include "core/render/view_transform.h"
#include "core/world/snapshot.h"

namespace camrig::render::scene {

/// A light in the optical frame of a view. Point and spot lights in one form: a point light has spot scale 0 and spot
/// offset 1 (KHR_lights_punctual).
struct LightInView {
    glm::vec3 towards{0.0f, 0.0f, -1.0f};  ///< unit, of a directional light
    glm::vec3 color{0.0f};                 ///< times intensity and exposure
    glm::vec3 position{0.0f};
    glm::vec3 direction{0.0f};
    float inverse_range2 = 0.0f;
    float spot_scale = 0.0f, spot_offset = 1.0f;
};
/// lamps_hz: those that flicker so are at their peak, all others as in the mean; 0: none.
LightInView light_in_view(const world::Light& light, const ViewTransform& view, float exposure, double lamps_hz = 0.0);

/// What all surfaces of a view share.
struct AmbientInView {
    glm::vec3 up{0.0f};                 ///< world up in the optical frame
    glm::vec3 sky{0.0f}, ground{0.0f};  ///< times the exposure
    float exposure = 1.0f;
};
/// Light from all around at one place, by normals in the optical frame; what is below 0 is none.
world::LightProbe surroundings_in_view(const world::LightProbe& probe, const ViewTransform& view);

AmbientInView ambient_in_view(const world::Environment& environment, float exposure, const ViewTransform& view);

}  // namespace camrig::render::scene
