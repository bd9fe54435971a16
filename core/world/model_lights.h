#pragma once

#include <vector>

#include "core/world/scene.h"

namespace camrig::world {

/// The KHR_lights_punctual lights of an object's model in its rest pose, in the world. Candela and lux become the
/// intensity of `Light` by 1/pi (there Lambert's 1/pi is folded in). A node that is scaled to nothing gives no light.
void append_model_lights(const Model& model, const ObjectSpec& object, std::vector<Light>& out);

/// T(position) * R(orientation) * scale.
glm::dmat4 world_from_model(const glm::dvec3& position, const glm::dquat& orientation, double scale);

}  // namespace camrig::world
