#include "core/bake/reflections.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <queue>

#include "core/bake/ray_sampling.h"
#include "core/world/scene.h"

namespace camrig::bake {
namespace {

/// Beyond the last level surfaces mirror no more than they scatter.
constexpr float roughest = world::reflection_levels[world::roughest_level].roughness;
constexpr float far_m = 12.0f;           ///< a place so far away is as good as none
constexpr float sample_m2 = 0.25f;       ///< of what mirrors, for a vote
constexpr int max_samples = 4096;        ///< of a triangle
constexpr float floor_share = 0.02f;     ///< of a place near the ground, where things that move may mirror
constexpr std::size_t max_voted = 4000;  ///< places that are weighed against each other
constexpr float least_gain = 0.0003f;    ///< of a place, as part of the first one's

bool mirrors(const world::Material& material) {
    return !material.unlit && (material.roughness < roughest || material.metallic_roughness_texture.texture >= 0);
}

struct Voted {
    glm::vec3 place{0.0f};
    float weight = 0.0f;
    float nearest_m = far_m;
};

/// Each place of the grid with the area of what mirrors before it.
class Votes {
public:
    Votes(const world::ProbeGrid& grid, std::span<const std::uint8_t> is_open) : grid_(grid), is_open_(is_open) {}

    void add(const glm::vec3& near, float weight) {
        glm::ivec3 at;
        for (glm::length_t i = 0; i < 3; ++i)
            at[i] = std::clamp(static_cast<int>(std::lround((near[i] - grid_.first[i]) / grid_.spacing_m)), 0,
                               grid_.count[i] - 1);
        const std::size_t index = index_of(at);
        if (is_open_[index] != 0) weights_[index] += weight;
    }
    /// Where whatever moves is.
    void add_ground() {
        const glm::ivec3 count = grid_.count;
        const auto weight = static_cast<float>(floor_share * grid_.spacing_m * grid_.spacing_m);
        for (int y = 0; y < count.y; ++y)
            for (int x = 0; x < count.x; ++x)
                if (const std::size_t index = index_of({x, y, std::min(1, count.z - 1)}); is_open_[index] != 0)
                    weights_[index] += weight;
    }
    std::vector<Voted> heaviest() const {
        std::vector<Voted> made;
        for (const auto& [index, weight] : weights_) made.push_back({place_of(index), weight});
        std::ranges::stable_sort(made, std::greater{}, &Voted::weight);
        made.resize(std::min(made.size(), max_voted));
        return made;
    }

private:
    std::size_t index_of(const glm::ivec3& at) const {
        const auto count = glm::uvec3(grid_.count), of = glm::uvec3(at);
        return (std::size_t{of.z} * count.y + of.y) * count.x + of.x;
    }
    glm::vec3 place_of(std::size_t index) const {
        const auto x = static_cast<std::size_t>(grid_.count.x), y = static_cast<std::size_t>(grid_.count.y);
        return glm::vec3(grid_.first + grid_.spacing_m * glm::dvec3(index % x, index / x % y, index / x / y));
    }

    const world::ProbeGrid& grid_;
    std::span<const std::uint8_t> is_open_;
    std::map<std::size_t, float> weights_;
};

void vote(const RaySurface& surface, float before_m, Votes& votes) {
    const auto& indices = surface.primitive->indices;
    for (std::size_t triangle = 0; triangle < indices.size() / 3; ++triangle) {
        const auto corner = [&](std::size_t k) { return surface.positions[indices[3 * triangle + k]]; };
        const float area = 0.5f * glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
        if (!(area > 0.0f)) continue;
        const int samples = std::clamp(static_cast<int>(area / sample_m2), 1, max_samples);
        const glm::vec3 before = surface.side_of(triangle) * before_m;
        for (int i = 0; i < samples; ++i) {
            // Evenly over a triangle: Osada et al., Shape distributions, 2002.
            const glm::vec2 at = spread_point(i, glm::vec2(0.5f));
            const float root = std::sqrt(at.x);
            const glm::vec3 place = surface.position_at(triangle, {1.0f - root, root * (1.0f - at.y), root * at.y});
            votes.add(place + before, area / static_cast<float>(samples));
        }
    }
}

/// How a GGX surface of that roughness spreads the halves between view and light about +z. Walter et al., Microfacet
/// models for refraction through rough surfaces, 2007.
glm::vec3 half_of(const glm::vec2& at, float roughness) {
    const float alpha2 = roughness * roughness * roughness * roughness;
    const float cosine = std::sqrt((1.0f - at.x) / (1.0f + (alpha2 - 1.0f) * at.x));
    const float sine = std::sqrt(std::max(0.0f, 1.0f - cosine * cosine));
    const float angle = 2.0f * std::numbers::pi_v<float> * at.y;
    return {sine * std::cos(angle), sine * std::sin(angle), cosine};
}

/// The middle of a texel, from -1 to 1, moved by parts of a texel.
glm::vec2 square_place(int x, int y, int side, const glm::vec2& moved = glm::vec2(0.0f)) {
    return (glm::vec2(x, y) + 0.5f + moved) * (2.0f / static_cast<float>(side)) - 1.0f;
}

}  // namespace

std::vector<glm::vec3> reflection_places(const RayScene& scene, const world::Scene& of, const world::ProbeGrid& grid,
                                         std::span<const std::uint8_t> is_open, std::size_t most) {
    Votes votes(grid, is_open);
    for (const RaySurface& surface : scene.surfaces())
        if (surface.is_lit && mirrors(*surface.material))
            vote(surface, static_cast<float>(0.5 * grid.spacing_m), votes);
    const bool has_mirrors = std::ranges::any_of(
        of.models, [](const auto& model) { return std::ranges::any_of(model.second.model->materials, mirrors); });
    if (!has_mirrors) return {};
    votes.add_ground();
    std::vector<Voted> voted = votes.heaviest();
    const auto gain_of = [&](std::size_t candidate) {
        float gain = 0.0f;
        for (const Voted& served : voted)
            gain +=
                served.weight * std::max(0.0f, served.nearest_m - glm::distance(served.place, voted[candidate].place));
        return gain;
    };
    // What a place gains never grows, so one whose gain of now is the best of the gains of before is the best: Minoux,
    // Accelerated greedy algorithms for maximizing submodular set functions, 1978.
    struct Gain {
        float value;
        std::size_t candidate;
        bool operator<(const Gain& other) const {
            return value != other.value ? value < other.value : candidate > other.candidate;
        }
    };
    std::priority_queue<Gain> gains;
    for (std::size_t i = 0; i < voted.size(); ++i) gains.push({gain_of(i), i});
    const float first_gain = gains.empty() ? 0.0f : gains.top().value;
    std::vector<glm::vec3> chosen;
    while (chosen.size() < most && !gains.empty()) {
        const std::size_t candidate = gains.top().candidate;
        gains.pop();
        const Gain now{gain_of(candidate), candidate};
        if (!gains.empty() && now < gains.top()) {
            gains.push(now);
            continue;
        }
        if (!(now.value > least_gain * first_gain)) break;
        chosen.push_back(voted[candidate].place);
        for (Voted& served : voted)
            served.nearest_m = std::min(served.nearest_m, glm::distance(served.place, chosen.back()));
    }
    return chosen;
}

ReflectionView reflection_view(const glm::vec3& place, std::span<const world::ReflectionLevel> levels,
                               std::size_t layers, const LookAlong& look) {
    constexpr std::array<int, world::reflection_levels.size()> rays{32, 96, 256, 4};
    constexpr int rays_of_nearness = 4;
    ReflectionView made;
    made.texels.assign(layers, {});
    std::vector<glm::vec3> seen(layers), sum(layers);
    for (std::size_t level = 0; level < levels.size(); ++level) {
        const auto [side, roughness] = levels[level];
        for (int y = 0; y < side; ++y) {
            for (int x = 0; x < side; ++x) {
                const Basis basis(world::octahedral_direction(square_place(x, y, side)));
                std::ranges::fill(sum, glm::vec3(0.0f));
                float weights = 0.0f;
                for (int i = 0; i < rays[level]; ++i) {
                    const glm::vec2 at = spread_point(i, glm::vec2(0.25f));
                    glm::vec3 along;
                    float weight = 1.0f;
                    if (roughness == 0.0f) {
                        along = world::octahedral_direction(square_place(x, y, side, at - 0.5f));
                    } else {
                        // The surface is seen along its normal.
                        const glm::vec3 half = half_of(at, roughness);
                        const glm::vec3 mirrored = 2.0f * half.z * half - glm::vec3(0.0f, 0.0f, 1.0f);
                        weight = mirrored.z;
                        along = basis.turned(mirrored);
                    }
                    if (!(weight > 0.0f)) continue;
                    std::ranges::fill(seen, glm::vec3(0.0f));
                    look({place, along}, seen);
                    for (std::size_t layer = 0; layer < layers; ++layer) sum[layer] += seen[layer] * weight;
                    weights += weight;
                }
                for (std::size_t layer = 0; layer < layers; ++layer)
                    made.texels[layer].push_back(sum[layer] / std::max(weights, 1e-6f));
            }
        }
    }
    for (int y = 0; y < world::nearness_side; ++y) {
        for (int x = 0; x < world::nearness_side; ++x) {
            float nearness = 0.0f;
            for (int i = 0; i < rays_of_nearness; ++i) {
                const glm::vec2 moved = spread_point(i, glm::vec2(0.25f)) - 0.5f;
                const Ray ray{place, world::octahedral_direction(square_place(x, y, world::nearness_side, moved))};
                nearness += world::nearness_of(look(ray, seen)) / static_cast<float>(rays_of_nearness);
            }
            made.nearness.push_back(static_cast<std::uint16_t>(std::lround(world::most_nearness * nearness)));
        }
    }
    return made;
}

}  // namespace camrig::bake
