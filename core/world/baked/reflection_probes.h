#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

/// Image-based lighting of what mirrors: what is to be seen from a few places to all sides.
namespace camrig::world {

/// What a reflection probe sees lies in squares, whose texels are directions: the octahedral map (Engelhardt and
/// Dachsbacher, Octahedron environment maps, 2008), +z in the middle, -z at the corners.
glm::vec3 octahedral_direction(const glm::vec2& at);     ///< unit, of a point of the square from -1 to 1
glm::vec2 octahedral_place(const glm::vec3& direction);  ///< the other way round

/// Level after level: what a surface of that roughness sees there (Karis, Real shading in Unreal Engine 4, 2013).
struct ReflectionLevel {
    int side = 0;  ///< texels
    float roughness = 0.0f;
};
inline constexpr std::array<ReflectionLevel, 4> reflection_levels{{{64, 0.0f}, {32, 0.2f}, {16, 0.4f}, {8, 0.6f}}};
/// Between two levels of roughness.
inline constexpr float roughness_of_level = 0.2f;
inline constexpr std::size_t texels_of_reflection = [] {
    std::size_t sum = 0;
    for (const ReflectionLevel& level : reflection_levels) sum += static_cast<std::size_t>(level.side * level.side);
    return sum;
}();
/// Distances have a square of their own.
inline constexpr int nearness_side = 64;
inline constexpr std::size_t texels_of_nearness = std::size_t{nearness_side} * nearness_side;

/// 1 / (1 + d), d: metres to what is seen. Between two of them it goes as pictures do.
constexpr float nearness_of(float distance_m) {
    return 1.0f / (1.0f + distance_m);
}

inline constexpr std::size_t max_reflection_probes = 64;

/// What they see is in the layers of light (LightLayer::reflections).
struct ReflectionProbes {
    std::vector<glm::vec3> places;        ///< world
    std::vector<std::uint16_t> nearness;  ///< probe after probe, row after row; of 65535
};

}  // namespace camrig::world
