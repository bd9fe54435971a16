#pragma once

#include <array>
#include <cstdint>
#include <span>

#include <glm/glm.hpp>

#include "core/world/snapshot.h"

namespace camrig::render::scene {

/// At most this many lights shade one draw; the strongest at the object win.
inline constexpr int max_lights_per_draw = 8;

/// The lights of one draw: indices into the snapshot's lights, directional ones first.
struct LightSet {
    std::array<std::uint16_t, max_lights_per_draw> lights{};
    std::uint8_t directional = 0;
    std::uint8_t local = 0;  ///< point and spot
    friend bool operator==(const LightSet&, const LightSet&) = default;
};

/// Distance at which a light falls below half a code of the darkest grey; its range if that is nearer.
double reach_m(const world::Light& light, float exposure);

/// Chooses the lights that can change a pixel of an object inside `centre`, `radius` (world). Deterministic: ties go to
/// the lower index. Few lights per draw is what makes shading affordable on a CPU.
LightSet select_lights(std::span<const world::Light> lights, float exposure, const glm::dvec3& centre, double radius);

}  // namespace camrig::render::scene
