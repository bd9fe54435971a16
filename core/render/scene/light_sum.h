#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/world/snapshot.h"

/// Baked light as it is now: its layers by the colours and strengths that their sources have.
namespace camrig::render::scene {

/// How much of each layer arrives, times the exposure. lamps_hz: those that flicker so are at their peak, all others as
/// in the mean; 0: none.
std::vector<glm::vec3> layer_weights(const world::StaticSet& statics, double lamps_hz = 0.0);

/// The map, in 16 bits a channel: light is a code over 65535, times `scale`. The fourth channel is full.
struct LightMapSum {
    std::vector<std::array<std::uint16_t, 4>> texels;
    float scale = 1.0f;
};
LightMapSum sum_map(const world::BakedLight& light, const std::vector<glm::vec3>& weights);
std::vector<world::LightProbe> sum_probes(const world::BakedLight& light, const std::vector<glm::vec3>& weights);

/// Between the probes around a place that are in the open; the nearest ones outside of the grid. nullopt: none is.
std::optional<world::LightProbe> probe_at(const world::ProbeGrid& grid, const std::vector<world::LightProbe>& probes,
                                          const glm::dvec3& place);

}  // namespace camrig::render::scene
