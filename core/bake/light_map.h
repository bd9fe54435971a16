#pragma once

#include <cstdint>
#include <vector>

#include "core/bake/ray_scene.h"
#include "core/world/baked/baked_light.h"

/// The places that texels of the map stand for.
namespace camrig::bake {

struct MapTexel {
    std::uint32_t index = 0;  ///< in the map
    std::uint32_t surface = 0, triangle = 0;
    glm::vec2 at{0.0f};  ///< its middle in the rectangle of the surface, in texels
};

/// A place of a surface, and which way it looks.
struct MapPlace {
    glm::vec3 position{0.0f};
    glm::vec3 side{0.0f};    ///< of the triangle, unit; where the surface has normals, towards their side
    glm::vec3 normal{0.0f};  ///< unit
    glm::vec3 shares{0.0f};  ///< of the triangle's corners
};

class LightMap {
public:
    /// Where surfaces of the scene have their rectangles; of those without, nothing.
    struct Origin {
        bool is_there = false;
        glm::ivec2 at{0};
    };
    LightMap(const RayScene& scene, ImageSize size, std::vector<Origin> origins);

    ImageSize size() const { return size_; }
    const std::vector<MapTexel>& texels() const { return texels_; }
    /// Into texels(); -1: none.
    const std::vector<std::int32_t>& texel_of_index() const { return texel_of_index_; }
    /// The place of a point of the texel, whose middle is 0; beside its triangle the next one of it.
    MapPlace place(const MapTexel& texel, const glm::vec2& beside = glm::vec2(0.0f)) const;
    /// Metres along a texel's side.
    float side_m(const MapTexel& texel) const;
    /// The texel that a hit lies in; -1: none.
    std::int32_t texel_at(const RayHit& hit) const;

private:
    void add_triangle(std::uint32_t surface, std::uint32_t triangle, std::vector<float>& distances);

    const RayScene& scene_;
    ImageSize size_;
    std::vector<Origin> origins_;  ///< by surface
    std::vector<MapTexel> texels_;
    std::vector<std::int32_t> texel_of_index_;
};

}  // namespace camrig::bake
