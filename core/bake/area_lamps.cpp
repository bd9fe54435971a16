#include "core/bake/area_lamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace camrig::bake {

AreaLamps::AreaLamps(const RayScene& scene) : scene_(scene) {
    constexpr glm::vec3 middle(1.0f / 3.0f);
    for (std::uint32_t i = 0; i < scene.surfaces().size(); ++i) {
        const RaySurface& surface = scene.surfaces()[i];
        if (!is_lamp(surface)) continue;
        const auto& indices = surface.primitive->indices;
        for (std::uint32_t number = 0; number < indices.size() / 3; ++number) {
            const auto corner = [&](std::size_t k) { return surface.positions[indices[3 * number + k]]; };
            Triangle made{i, number, surface.position_at(number, middle), surface.side_of(number)};
            made.area = 0.5f * glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
            const glm::vec3 light = scene.glow(i, number, middle);
            made.power = made.area * std::max({light.r, light.g, light.b});
            if (made.power > 0.0f) triangles_.push_back(made);
        }
    }
}

bool AreaLamps::is_lamp(const RaySurface& surface) {
    const glm::vec3& light = surface.material->emissive;
    return surface.is_lit && std::max({light.r, light.g, light.b}) > 1.0f;
}

void AreaLamps::weigh(const glm::vec3& place, const glm::vec3& normal, bool both_sides,
                      std::vector<float>& sums) const {
    sums.clear();
    float sum = 0.0f;
    for (const Triangle& lamp : triangles_) {
        const glm::vec3 way = lamp.middle - place;
        const float distance2 = std::max(glm::dot(way, way), lamp.area), distance = std::sqrt(distance2);
        float cosine = normal == glm::vec3(0.0f) ? 1.0f : glm::dot(normal, way) / distance;
        if (both_sides) cosine = std::abs(cosine);
        sum += lamp.power * std::max(0.0f, cosine) * std::max(0.0f, -glm::dot(lamp.side, way)) / (distance2 * distance);
        sums.push_back(sum);
    }
}

std::optional<AreaLamps::Sample> AreaLamps::sample(const std::vector<float>& sums, const glm::vec3& place,
                                                   glm::vec2 at) const {
    if (sums.empty() || !(sums.back() > 0.0f)) return std::nullopt;
    const float wanted = at.x * sums.back();
    const auto found = std::min(std::ranges::upper_bound(sums, wanted), sums.end() - 1);
    const float before = found == sums.begin() ? 0.0f : *(found - 1), part = *found - before;
    if (!(part > 0.0f)) return std::nullopt;
    const Triangle& lamp = triangles_[static_cast<std::size_t>(found - sums.begin())];
    // What is left of the first number is as good as a new one.
    const float root = std::sqrt(std::clamp((wanted - before) / part, 0.0f, 1.0f));
    const glm::vec3 shares(1.0f - root, root * (1.0f - at.y), root * at.y);
    const glm::vec3 way = scene_.surfaces()[lamp.surface].position_at(lamp.number, shares) - place;
    Sample made;
    made.distance = glm::length(way);
    if (!(made.distance > 1e-4f)) return std::nullopt;
    made.towards = way / made.distance;
    const float cosine = -glm::dot(lamp.side, made.towards);
    if (!(cosine > 0.0f)) return std::nullopt;
    // Next to a lamp no more than what a place right before it has.
    const float distance2 = std::max(made.distance * made.distance, lamp.area);
    const float seen = lamp.area * cosine / (std::numbers::pi_v<float> * distance2);
    made.light = scene_.glow(lamp.surface, lamp.number, shares) * (seen * sums.back() / part);
    return made;
}

}  // namespace camrig::bake
