#pragma once

#include <cmath>

#include <glm/glm.hpp>

#include "core/world/model.h"

namespace camrig::render::scene {

/// Where on its texture a point is: rows of a 2x3 matrix for (u, v, 1).
struct TextureTransform {
    glm::vec3 u{1.0f, 0.0f, 0.0f};
    glm::vec3 v{0.0f, 1.0f, 0.0f};

    glm::vec2 operator()(glm::vec2 at) const { return {u.x * at.x + u.y * at.y + u.z, v.x * at.x + v.y * at.y + v.z}; }
};

/// KHR_texture_transform: translation * rotation * scale; counter-clockwise with v pointing down.
inline TextureTransform transform_of(const world::TextureRef& ref) {
    const float c = std::cos(ref.rotation), s = std::sin(ref.rotation);
    return {.u = {c * ref.scale.x, s * ref.scale.y, ref.offset.x},
            .v = {-s * ref.scale.x, c * ref.scale.y, ref.offset.y}};
}

}  // namespace camrig::render::scene
