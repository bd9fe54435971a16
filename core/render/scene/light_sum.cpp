#include "core/render/scene/light_sum.h"

#include <algorithm>
#include <cmath>

#include "core/world/baked/shared_exponent.h"

namespace camrig::render::scene {

std::vector<glm::vec3> layer_weights(const world::StaticSet& statics, double lamps_hz) {
    const world::Environment& environment = statics.environment;
    std::vector<glm::vec3> weights;
    for (const world::LightLayer& layer : statics.baked_light->layers) {
        glm::vec3 weight(1.0f);
        switch (layer.source) {
            case world::LightSource::sky:
                weight = environment.ambient_sky;
                break;
            case world::LightSource::ground:
                weight = environment.ambient_ground;
                break;
            case world::LightSource::glow:
                weight = glm::vec3(environment.glow);
                break;
            case world::LightSource::lamp: {
                const world::Light& lamp = statics.lights[layer.lamps.front()];
                weight = lamp.color * lamp.intensity;
                if (lamp.flicker_hz == lamps_hz) weight *= 1.0f + lamp.flicker_depth;
                break;
            }
        }
        weights.push_back(weight * environment.exposure);
    }
    return weights;
}

LightMapSum sum_map(const world::BakedLight& light, const std::vector<glm::vec3>& weights) {
    const auto count = static_cast<std::size_t>(light.size.pixels());
    std::vector<glm::vec3> sums(count, glm::vec3(0.0f));
    for (std::size_t layer = 0; layer < light.layers.size(); ++layer) {
        if (weights[layer] == glm::vec3(0.0f)) continue;
        const std::uint32_t* const texels = light.layers[layer].texels.data();
        for (std::size_t i = 0; i < count; ++i) sums[i] += world::unpacked_light(texels[i]) * weights[layer];
    }
    // Beside a bright lamp all else would have few codes: what is over 64 times the mean is cut there.
    glm::dvec3 total(0.0);
    float most = 0.0f;
    for (const glm::vec3& sum : sums) {
        total += glm::dvec3(sum);
        most = std::max(most, std::max(sum.r, std::max(sum.g, sum.b)));
    }
    const double mean = (total.r + total.g + total.b) / (3.0 * std::max(1.0, static_cast<double>(count)));
    LightMapSum made;
    made.scale = std::max(std::min(most, static_cast<float>(64.0 * mean)), 1e-6f);
    made.texels.resize(count);
    const float codes = 65535.0f / made.scale;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 at = glm::clamp(sums[i] * codes, 0.0f, 65535.0f) + 0.5f;
        made.texels[i] = {static_cast<std::uint16_t>(at.r), static_cast<std::uint16_t>(at.g),
                          static_cast<std::uint16_t>(at.b), 65535};
    }
    return made;
}

std::vector<world::LightProbe> sum_probes(const world::BakedLight& light, const std::vector<glm::vec3>& weights) {
    std::vector<world::LightProbe> sums(light.grid.size());
    for (std::size_t layer = 0; layer < light.layers.size(); ++layer)
        for (std::size_t i = 0; i < sums.size(); ++i) sums[i] += light.layers[layer].probes[i].scaled(weights[layer]);
    return sums;
}

std::optional<world::LightProbe> probe_at(const world::ProbeGrid& grid, const std::vector<world::LightProbe>& probes,
                                          const glm::dvec3& place) {
    glm::ivec3 first;
    glm::dvec3 share;
    for (glm::length_t i = 0; i < 3; ++i) {
        const double at = std::clamp((place[i] - grid.first[i]) / grid.spacing_m, 0.0, grid.count[i] - 1.0);
        first[i] = std::min(static_cast<int>(at), std::max(0, grid.count[i] - 2));
        share[i] = at - first[i];
    }
    world::LightProbe sum;
    double weights = 0.0;
    for (int corner = 0; corner < 8; ++corner) {
        double weight = 1.0;
        std::size_t index = 0;
        for (glm::length_t i = 2; i >= 0; --i) {
            const int step = corner >> i & 1;
            weight *= step == 1 ? share[i] : 1.0 - share[i];
            index = index * static_cast<std::size_t>(grid.count[i]) +
                    static_cast<std::size_t>(std::min(first[i] + step, grid.count[i] - 1));
        }
        // A little of each, so that between a wall's probe and an open one there is always an answer.
        weight += 1e-3;
        if (grid.is_open[index] == 0) continue;
        sum += probes[index].scaled(glm::vec3(static_cast<float>(weight)));
        weights += weight;
    }
    if (weights == 0.0) return std::nullopt;
    return sum.scaled(glm::vec3(static_cast<float>(1.0 / weights)));
}

}  // namespace camrig::render::scene
