#pragma once

#include "core/world/model.h"
#include "core/world/snapshot.h"

/// Models and worlds made in code, so that the right answer is known exactly. Models are given in the world's z-up
/// frame (the one node undoes the loader's turn), so a vertex at (1, 2, 3) is at (1, 2, 3) in the world.
namespace camrig::render {

/// A model with one mesh of one primitive and one material.
std::shared_ptr<world::Model> model_of(world::Primitive primitive, world::Material material);

/// Rectangle with corners centre +- u +- v; normal along u x v; texture coordinates (0, 0) at centre - u + v (top left
/// when u points right and v up) to (1, 1) at centre + u - v.
world::Primitive rectangle(glm::vec3 centre, glm::vec3 u, glm::vec3 v);
world::Primitive triangles(std::vector<glm::vec3> corners);
/// Axis-aligned box around the origin with outward normals.
world::Primitive box(glm::vec3 half);

world::Material colored(glm::vec3 linear, bool unlit = false);

world::Instance instance_of(world::ModelRef model, glm::dvec3 position = glm::dvec3(0.0), std::uint32_t id = 1);

world::Light light_of(world::LightType type, float intensity, glm::dvec3 position = glm::dvec3(0.0),
                      glm::dvec3 direction = glm::dvec3(0.0, 0.0, -1.0));

/// A world of these objects, ambient light 1 everywhere, black background.
struct TestWorld {
    std::vector<world::Instance> objects;
    std::vector<world::Instance> movers;
    std::vector<world::Light> lights;
    world::Environment environment{
        .background = glm::vec3(0.0f), .ambient_sky = glm::vec3(1.0f), .ambient_ground = glm::vec3(1.0f)};
    world::SnapshotRef snapshot(TimeNs world_ns = 0) const;
};

}  // namespace camrig::render
