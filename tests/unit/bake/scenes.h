#pragma once

#include <string>
#include <vector>

#include "core/bake/bake.h"
#include "core/world/baked/baked_light_file.h"

/// Scenes of boxes whose light is known, and their baked light.
namespace camrig::bake {

/// A box of the scene: its middle is at the middle of its bottom.
struct TestBox {
    std::string name;
    glm::dvec3 position{0.0}, size{1.0};
    double color = 0.5;
};

/// From the text of a scene file: `boxes` as objects; `rest`: more keys, from a comma on.
world::SceneRef scene_of(const std::vector<TestBox>& boxes, const std::string& rest = "");

/// Six walls of half a metre about a room of that size, whose floor is at z = 0.
std::vector<TestBox> room(const glm::dvec3& size, double color);

world::BakedLight baked(const world::SceneRef& scene, BakeOptions options = {.texels_per_m = 4.0, .rays = 256});

/// Light of a layer on the surface of an object at a place, which looks that way, as its texels and their filter give
/// it.
glm::vec3 light_at(const world::SceneRef& scene, const world::BakedLight& light, std::size_t layer,
                   const std::string& object, const glm::dvec3& place, const glm::dvec3& normal);

/// The layer of this source; of lamps the first.
std::size_t layer_of(const world::BakedLight& light, world::LightSource source);

}  // namespace camrig::bake
