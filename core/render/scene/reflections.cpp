#include "core/render/scene/reflections.h"

#include "core/world/baked/shared_exponent.h"

namespace camrig::render::scene {
namespace {

/// Which texel of a square lies there, at most one beyond an edge: the octahedral map goes on mirrored about the middle
/// of that edge.
int texel_beyond(int x, int y, int side) {
    const int last = side - 1;
    if (x < 0 || x > last) {
        x = x < 0 ? 0 : last;
        y = last - y;
    }
    if (y < 0 || y > last) {
        y = y < 0 ? 0 : last;
        x = last - x;
    }
    return y * side + x;
}

template <typename To, typename Value>
void add_bordered(int side, const Value& value, std::vector<To>& to) {
    for (int y = -1; y <= side; ++y)
        for (int x = -1; x <= side; ++x) to.push_back(value(static_cast<std::size_t>(texel_beyond(x, y, side))));
}

}  // namespace

ReflectionMaps sum_reflections(const world::BakedLight& light, const std::vector<glm::vec3>& weights) {
    ReflectionMaps made;
    const std::size_t probes = light.reflection_probes.places.size();
    made.texels.reserve(static_cast<std::size_t>(ReflectionMaps::start_of(static_cast<std::int32_t>(probes))));
    std::size_t first = 0;
    for (std::size_t probe = 0; probe < probes; ++probe) {
        for (const world::ReflectionLevel& level : world::levels_of_probe(probe)) {
            add_bordered(
                level.side,
                [&](std::size_t texel) {
                    glm::vec3 sum(0.0f);
                    for (std::size_t layer = 0; layer < weights.size(); ++layer)
                        sum += world::unpacked_light(light.layers[layer].reflections[first + texel]) * weights[layer];
                    return world::packed_light(sum);
                },
                made.texels);
            first += level.texels();
        }
    }
    return made;
}

std::vector<float> bordered_nearness(const world::ReflectionProbes& probes) {
    std::vector<float> made;
    made.reserve(probes.places.size() * static_cast<std::size_t>(bordered_texels(world::nearness_side)));
    for (std::size_t probe = 0; probe < probes.places.size(); ++probe) {
        const std::uint16_t* const nearness = probes.nearness.data() + probe * world::texels_of_nearness;
        add_bordered(
            world::nearness_side,
            [&](std::size_t texel) { return static_cast<float>(nearness[texel]) * (1.0f / world::most_nearness); },
            made);
    }
    return made;
}

ProbeSights sights_of(const world::ReflectionProbes& probes) {
    return {ProbeCells(probes.places), bordered_nearness(probes)};
}

ReflectionsInView reflections_in_view(const ReflectionMaps& maps, const ProbeSights& sights, const ViewTransform& view,
                                      const glm::vec3& gain) {
    return {&maps, &sights, glm::vec3(view.eye - sights.cells.first()),
            glm::transpose(glm::mat3(view.optical_from_world)), gain};
}

}  // namespace camrig::render::scene
