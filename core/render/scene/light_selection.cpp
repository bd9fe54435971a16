#include "core/render/scene/light_selection.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace camrig::render::scene {
namespace {

// The sRGB curve starts with slope 12.92: half a code of 255 is this much linear light.
constexpr double invisible_radiance = 0.5 / 255.0 / 12.92;

double brightness(const world::Light& light, float exposure) {
    return static_cast<double>(std::max({light.color.r, light.color.g, light.color.b})) * light.intensity * exposure;
}

/// True if the sphere is certainly outside the spot's cone.
bool outside_cone(const world::Light& light, const glm::dvec3& centre, double radius) {
    const double angle = light.outer_cone_rad;
    const glm::dvec3 to_centre = centre - light.position;
    const double along = glm::dot(to_centre, light.direction);
    const double across = std::sqrt(std::max(0.0, glm::dot(to_centre, to_centre) - along * along));
    // Signed distance of the centre to the cone's surface; exact beside it, too small (safe) behind its tip.
    return across * std::cos(angle) - along * std::sin(angle) > radius;
}

}  // namespace

double reach_m(const world::Light& light, float exposure) {
    const double fades_at = std::sqrt(brightness(light, exposure) / invisible_radiance);
    return light.range > 0.0f ? std::min(fades_at, static_cast<double>(light.range)) : fades_at;
}

LightSet select_lights(std::span<const world::Light> lights, float exposure, const glm::dvec3& centre, double radius) {
    struct Candidate {
        double strength;
        std::uint16_t index;
        bool directional;
    };
    static thread_local std::vector<Candidate> candidates;  // for every mover at every instant: keeps its memory
    candidates.clear();
    for (std::size_t i = 0; i < lights.size(); ++i) {
        const world::Light& light = lights[i];
        const double bright = brightness(light, exposure);
        if (!(bright > 0.0)) continue;
        const auto index = static_cast<std::uint16_t>(i);
        if (light.type == world::LightType::directional) {
            candidates.push_back({bright, index, true});
            continue;
        }
        const double distance = std::max(0.0, glm::distance(centre, light.position) - radius);
        if (distance >= reach_m(light, exposure)) continue;
        if (light.type == world::LightType::spot && outside_cone(light, centre, radius)) continue;
        candidates.push_back({bright / std::max(distance * distance, 1e-6), index, false});
    }
    if (candidates.size() > max_lights_per_draw) {
        // The sun shines on all of what lamps may light in one place.
        std::ranges::stable_sort(candidates, [](const Candidate& a, const Candidate& b) {
            return a.directional != b.directional ? a.directional : a.strength > b.strength;
        });
        candidates.resize(max_lights_per_draw);
    }
    std::ranges::sort(candidates, [](const Candidate& a, const Candidate& b) {
        return a.directional != b.directional ? a.directional : a.index < b.index;
    });

    LightSet set;
    for (std::size_t i = 0; i < candidates.size(); ++i) {
        set.lights[i] = candidates[i].index;
        ++(candidates[i].directional ? set.directional : set.local);
    }
    return set;
}

}  // namespace camrig::render::scene
