#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include <glm/glm.hpp>

#include "core/world/model.h"

namespace camrig::world {

/// What one object has otherwise than its model's file.
struct MaterialLook {
    glm::vec3 tint{1.0f};  ///< factor on the material's base color
    bool is_hidden = false;
};
/// Per material of the model; empty: all is as in the file.
using Look = std::vector<MaterialLook>;
/// Of a material of the model; below 0: of none.
inline MaterialLook look_of(const Look& look, int material) {
    return look.empty() || material < 0 ? MaterialLook{} : look[static_cast<std::size_t>(material)];
}

/// The look of a variant of a model: its colors and what it wears are functions of this number and of names in the
/// model alone, so equal numbers look alike in every world. nullopt: as the file has it.
Look look_of(const Model& model, std::optional<std::uint64_t> variant);

}  // namespace camrig::world
