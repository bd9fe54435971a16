#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <vector>

#include <glm/glm.hpp>

#include "core/render/scene/probe_cells.h"
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
    /// Where each level of a probe begins. A mirror's is the last one: a probe without it ends there.
    static constexpr auto level_starts = [] {
        std::array<std::int32_t, world::reflection_levels.size()> starts{};
        for (std::size_t i = 0; i + 1 < world::reflection_levels.size(); ++i)
            starts[i + 1] = starts[i] + bordered_texels(world::reflection_levels[i].side);
        return starts;
    }();
    static constexpr std::int32_t texels_of_mirror =
        bordered_texels(world::reflection_levels[world::mirror_level].side);
    /// Where a probe begins.
    static constexpr std::int32_t start_of(std::int32_t probe) {
        return probe * level_starts[world::mirror_level] +
               std::min(probe, static_cast<std::int32_t>(world::most_mirror_probes)) * texels_of_mirror;
    }

    std::vector<std::uint32_t> texels;  ///< as world::packed_light()
};

/// weights: of the layers.
ReflectionMaps sum_reflections(const world::BakedLight& light, const std::vector<glm::vec3>& weights);

/// What no change of light changes of them.
struct ProbeSights {
    ProbeCells cells;
    std::vector<float> nearness;  ///< world::nearness_of(), by squares of world::nearness_side with a border
};
std::vector<float> bordered_nearness(const world::ReflectionProbes& probes);
ProbeSights sights_of(const world::ReflectionProbes& probes);

/// Both for the pixels of a view.
struct ReflectionsInView {
    const ReflectionMaps* maps = nullptr;  ///< null: there are none
    const ProbeSights* sights = nullptr;
    glm::vec3 eye{0.0f};  ///< from ProbeCells::first
    glm::mat3 world_from_optical{1.0f};
    glm::vec3 gain{1.0f};  ///< of what the maps have
};
ReflectionsInView reflections_in_view(const ReflectionMaps& maps, const ProbeSights& sights, const ViewTransform& view,
                                      const glm::vec3& gain);

}  // namespace camrig::render::scene
