#pragma once

#include "core/world/model.h"
#include "core/world/snapshot.h"

/// Models and worlds made in code, so that the right answer is known exactly. Models are given in the world's z-up
/// frame (the one node undoes the loader's turn), so a vertex at (1, 2, 3) is at (1, 2, 3) in the world.
namespace camrig {

/// A model with one mesh of one primitive and one material.
std::shared_ptr<Model> model_of(Primitive primitive, Material material);

/// Rectangle with corners centre +- u +- v; normal along u x v; texture coordinates (0, 0) at centre - u + v (top left
/// when u points right and v up) to (1, 1) at centre + u - v.
Primitive rectangle(glm::vec3 centre, glm::vec3 u, glm::vec3 v);
Primitive triangles(std::vector<glm::vec3> corners);
/// Axis-aligned box around the origin with outward normals.
Primitive box(glm::vec3 half);

Material colored(glm::vec3 linear, bool unlit = false);

Instance instance_of(ModelRef model, glm::dvec3 position = glm::dvec3(0.0), std::uint32_t id = 1);

Light light_of(LightType type, float intensity, glm::dvec3 position = glm::dvec3(0.0),
               glm::dvec3 direction = glm::dvec3(0.0, 0.0, -1.0));

/// A world of these objects, ambient light 1 everywhere, black background.
struct TestWorld {
    std::vector<Instance> objects;
    std::vector<Instance> movers;
    std::vector<Light> lights;
    Environment environment{
        .background = glm::vec3(0.0f), .ambient_sky = glm::vec3(1.0f), .ambient_ground = glm::vec3(1.0f)};
    SnapshotRef snapshot(TimeNs world_ns = 0) const;
};

}  // namespace camrig
