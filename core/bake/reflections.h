#pragma once

#include <functional>
#include <span>
#include <vector>

#include "core/bake/ray_scene.h"
#include "core/world/baked/baked_light.h"
#include "core/world/baked/reflection_probes.h"

/// What mirrors see: where reflection probes stand, and what there is around them.
namespace camrig::bake {

/// Places of the grid in the open, `most` at most, so that what mirrors is near to one: facility location, solved
/// greedily (Cornuejols et al., 1977), until one more would gain less than 0.0003 of the first. None in a scene
/// where nothing mirrors.
std::vector<glm::vec3> reflection_places(const RayScene& scene, const world::Scene& of, const world::ProbeGrid& grid,
                                         std::span<const std::uint8_t> is_open, std::size_t most);

/// Adds, by layer, the light that comes along the ray; metres to where it comes from, infinite beyond the scene.
using LookAlong = std::function<float(const Ray& ray, std::span<glm::vec3> by_layer)>;

/// What one probe sees.
struct ReflectionView {
    std::vector<std::vector<glm::vec3>> texels;  ///< by layer, then level after level
    std::vector<std::uint16_t> nearness;
};
ReflectionView reflection_view(const glm::vec3& place, std::span<const world::ReflectionLevel> levels,
                               std::size_t layers, const LookAlong& look);

}  // namespace camrig::bake
