#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/render/view_transform.h"
#include "core/world/baked/baked_light.h"

/// Reflection probes as they are now: their layers by the colours and strengths that the sources have.
namespace camrig::render::scene {

/// Of a square with its border.
constexpr int bordered_side(int side) {
    return side + 2;
}
constexpr int bordered_texels(int side) {
    return bordered_side(side) * bordered_side(side);
}

/// Squares of all probes and levels, each with a border that is what lies beyond its edges, so that pixels between
/// texels are as anywhere else.
struct ReflectionMaps {
    /// Where each level of a probe begins; last: where the next probe does.
    static constexpr auto level_starts = [] {
        std::array<std::int32_t, world::reflection_levels.size() + 1> starts{};
        for (std::size_t i = 0; i < world::reflection_levels.size(); ++i)
            starts[i + 1] = starts[i] + bordered_texels(world::reflection_levels[i].side);
        return starts;
    }();

    std::vector<std::uint32_t> texels;  ///< as world::packed_light()
    std::vector<float> nearness;        ///< world::nearness_of(), by squares of world::nearness_side
};

/// weights: of the layers.
ReflectionMaps sum_reflections(const world::BakedLight& light, const std::vector<glm::vec3>& weights);

/// Them for the pixels of a view.
struct ReflectionsInView {
    const ReflectionMaps* maps = nullptr;      ///< null: there are none
    std::array<std::vector<float>, 3> places;  ///< of the probes, by coordinate in the optical frame
    glm::mat3 world_from_optical{1.0f};
    glm::vec3 gain{1.0f};  ///< of what the maps have
};
ReflectionsInView reflections_in_view(const ReflectionMaps& maps, const world::ReflectionProbes& probes,
                                      const ViewTransform& view, const glm::vec3& gain);

}  // namespace camrig::render::scene
