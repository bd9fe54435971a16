#include "core/bake/area_lamps.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace camrig::bake {

namespace {

float sent(float cosine, bool both_sides) {
    return both_sides ? std::abs(cosine) : std::max(0.0f, cosine);
}

/// How bright a triangle is at its brightest, about: where its texture was not looked at it may shine, too.
float brightness(const RayScene& scene, std::uint32_t surface, std::uint32_t number) {
    constexpr int side = 8;
    constexpr float unseen_share = 1.0f / 16.0f;
    const auto most = [](const glm::vec3& light) { return std::max({light.r, light.g, light.b}); };
    float made = unseen_share * most(scene.surfaces()[surface].material->emissive);
    for (int i = 0; i < side; ++i) {
        for (int j = 0; j < side - i; ++j) {
            const glm::vec2 at = (glm::vec2(static_cast<float>(i), static_cast<float>(j)) + 1.0f / 3.0f) / float{side};
            made = std::max(made, most(scene.glow(surface, number, {1.0f - at.x - at.y, at.x, at.y})));
        }
    }
    return made;
}

}  // namespace

AreaLamps::AreaLamps(const RayScene& scene) : scene_(scene) {
    for (std::uint32_t i = 0; i < scene.surfaces().size(); ++i) {
        const RaySurface& surface = scene.surfaces()[i];
        if (!is_lamp(surface)) continue;
        const auto& indices = surface.primitive->indices;
        for (std::uint32_t number = 0; number < indices.size() / 3; ++number) {
            Triangle made{.surface = i, .number = number, .side = surface.side_of(number)};
            made.both_sides = surface.material->double_sided;
            for (std::size_t k = 0; k < 3; ++k) made.corners[k] = surface.positions[indices[3 * number + k]];
            made.middle = surface.position_at(number, glm::vec3(1.0f / 3.0f));
            made.area =
                0.5f * glm::length(glm::cross(made.corners[1] - made.corners[0], made.corners[2] - made.corners[0]));
            made.power = made.area * brightness(scene, i, number);
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
    const auto cosine_of = [&](const glm::vec3& way, float distance) {
        const float cosine = normal == glm::vec3(0.0f) ? 1.0f : glm::dot(normal, way) / distance;
        return sent(cosine, both_sides);
    };
    for (const Triangle& lamp : triangles_) {
        const glm::vec3 way = lamp.middle - place;
        const float distance2 = std::max(glm::dot(way, way), lamp.area), distance = std::sqrt(distance2);
        // A part may be in front of the place whose middle is not.
        constexpr float corner_share = 0.25f;
        float cosine = cosine_of(way, distance);
        for (const glm::vec3& corner : lamp.corners)
            cosine = std::max(cosine, corner_share * cosine_of(corner - place, glm::distance(corner, place)));
        sum += lamp.power * cosine * sent(-glm::dot(lamp.side, way), lamp.both_sides) / (distance2 * distance);
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
    const float cosine = sent(-glm::dot(lamp.side, made.towards), lamp.both_sides);
    if (!(cosine > 0.0f)) return std::nullopt;
    // Next to a lamp no more than what its middle sends from a quarter of its side away: few samples have all the
    // light.
    constexpr float nearest_share = 1.0f / 16.0f;
    const float distance2 = std::max(made.distance * made.distance, nearest_share * lamp.area);
    const float seen = lamp.area * cosine / (std::numbers::pi_v<float> * distance2);
    made.light = scene_.glow(lamp.surface, lamp.number, shares) * (seen * sums.back() / part);
    return made;
}

}  // namespace camrig::bake
