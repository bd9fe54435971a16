#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "core/bake/texture_colors.h"
#include "core/render/scene/placed_scene.h"

/// What stands still in a scene, for rays. Embree finds what they hit (Wald et al., Embree: a kernel framework for
/// efficient CPU ray tracing, 2014).
namespace camrig::bake {

/// A placed primitive, in the world.
struct RaySurface {
    const render::scene::PlacedSurface* placed = nullptr;
    const world::Primitive* primitive = nullptr;
    const world::Material* material = nullptr;
    std::vector<glm::vec3> positions;
    std::vector<glm::vec3> normals;  ///< unit; empty: it has none
    bool is_lit = false;

    glm::vec3 position_at(std::size_t triangle, const glm::vec3& shares) const;
    /// The way that the triangle winds, unit; 0 without an area.
    glm::vec3 side_of(std::size_t triangle) const;
    /// Of the vertices; that of the triangle where they have none. Unit.
    glm::vec3 normal_at(std::size_t triangle, const glm::vec3& shares) const;
};

struct Ray {
    glm::vec3 from, along;  ///< along: unit
    float length = 1e30f;
};

/// A place on a surface.
struct RayHit {
    std::uint32_t surface = 0, triangle = 0;
    glm::vec3 shares{0.0f};  ///< of the corners
    float distance = 0.0f;
    bool is_front = false;
};

class RayScene {
public:
    /// The scene must stay.
    explicit RayScene(const render::scene::PlacedScene& scene);
    ~RayScene();
    RayScene(const RayScene&) = delete;
    RayScene& operator=(const RayScene&) = delete;

    const std::vector<RaySurface>& surfaces() const { return surfaces_; }
    const TextureColors& colors() const { return colors_; }

    /// The first thing that a ray meets, after what is blended or cut out; `through`: what these let pass. nullopt: it
    /// leaves the scene. Any thread.
    std::optional<RayHit> first_hit(Ray ray, glm::vec3& through) const;
    /// How much of each colour of light comes along the ray; what is unlit is in nobody's light.
    glm::vec3 open_share(Ray ray) const;
    /// Base colour of a place, linear, with its alpha.
    glm::vec4 base_color(std::uint32_t surface, std::uint32_t triangle, const glm::vec3& shares) const;
    /// Radiance that it sends out by itself.
    glm::vec3 glow(std::uint32_t surface, std::uint32_t triangle, const glm::vec3& shares) const;

private:
    struct Embree;
    std::optional<RayHit> nearest(const Ray& ray) const;

    std::vector<RaySurface> surfaces_;
    TextureColors colors_;
    std::unique_ptr<Embree> embree_;
};

}  // namespace camrig::bake
