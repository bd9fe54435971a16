#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

/// Image-based lighting of what mirrors: what is to be seen from a few places to all sides.
namespace camrig::world {

/// What a reflection probe sees lies in squares, whose texels are directions: the octahedral map (Engelhardt and
/// Dachsbacher, Octahedron environment maps, 2008), +z in the middle, -z at the corners.
glm::vec3 octahedral_direction(const glm::vec2& at);     ///< unit, of a point of the square from -1 to 1
glm::vec2 octahedral_place(const glm::vec3& direction);  ///< the other way round

/// Level after level: what a surface of that roughness sees there (Karis, Real shading in Unreal Engine 4, 2013). The
/// last one is for mirrors; the others, from smooth to rough, are for what spreads what it mirrors.
struct ReflectionLevel {
    int side = 0;  ///< texels
    float roughness = 0.0f;

    constexpr std::size_t texels() const { return static_cast<std::size_t>(side) * static_cast<std::size_t>(side); }
};
inline constexpr std::array<ReflectionLevel, 4> reflection_levels{{{32, 0.15f}, {16, 0.35f}, {8, 0.6f}, {64, 0.0f}}};
inline constexpr std::size_t mirror_level = reflection_levels.size() - 1, roughest_level = mirror_level - 1;
/// Four fifths of a probe's texels are a mirror's, and what is rough wants more places, not finer images: only so many
/// probes, the first, have that level.
inline constexpr std::size_t most_mirror_probes = 32;
constexpr std::span<const ReflectionLevel> levels_of_probe(std::size_t probe) {
    return std::span(reflection_levels).first(probe < most_mirror_probes ? mirror_level + 1 : mirror_level);
}
/// Of so many probes, of all their levels.
constexpr std::size_t texels_of_reflections(std::size_t probes) {
    std::size_t sum = 0;
    for (std::size_t probe = 0; probe < probes; ++probe)
        for (const ReflectionLevel& level : levels_of_probe(probe)) sum += level.texels();
    return sum;
}
/// Distances have a square of their own.
inline constexpr int nearness_side = 64;
inline constexpr std::size_t texels_of_nearness = std::size_t{nearness_side} * nearness_side;

/// 1 / (1 + d), d: metres to what is seen. Between two of them it goes as pictures do. As a whole number it is of
/// `most_nearness`.
constexpr float nearness_of(float distance_m) {
    return 1.0f / (1.0f + distance_m);
}

inline constexpr int most_nearness = 4095;

inline constexpr std::size_t max_reflection_probes = 256;

/// What they see is in the layers of light (LightLayer::reflections).
struct ReflectionProbes {
    std::vector<glm::vec3> places;        ///< world; the first of them alone serve any scene best
    std::vector<std::uint16_t> nearness;  ///< probe after probe, row after row; of most_nearness
};

}  // namespace camrig::world
