#pragma once

#include <glm/glm.hpp>

#include "core/world/model.h"

namespace camrig::bake {

/// Colours of textures at single places, linear. Between texels nothing is interpolated: whoever asks takes means.
class TextureColors {
public:
    TextureColors();
    /// White where there is no texture.
    glm::vec4 of(const world::Model& model, const world::TextureRef& ref, const world::Primitive& primitive,
                 const glm::uvec3& corners, const glm::vec3& shares) const;

private:
    float linear_[256];  ///< of codes of sRGB
};

}  // namespace camrig::bake
