#include "core/bake/light_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace camrig::bake {
namespace {

/// Texels whose middles are so far beside a triangle are read where it ends.
constexpr float reach_texels = 1.5f;

using MapCorners = std::array<glm::vec2, 3>;

MapCorners coordinates_of(const world::Primitive& primitive, std::size_t triangle) {
    MapCorners made;
    for (std::size_t k = 0; k < 3; ++k) made[k] = primitive.light_coordinates[primitive.indices[3 * triangle + k]];
    return made;
}

/// Shares of the corners at the place of a triangle that is next to a point.
glm::vec3 nearest_shares(const MapCorners& corners, const glm::vec2& at) {
    const auto cross = [](const glm::vec2& a, const glm::vec2& b) { return a.x * b.y - a.y * b.x; };
    const float area = cross(corners[1] - corners[0], corners[2] - corners[0]);
    if (std::abs(area) > 1e-12f) {
        const glm::vec3 shares(cross(corners[1] - at, corners[2] - at) / area,
                               cross(corners[2] - at, corners[0] - at) / area,
                               cross(corners[0] - at, corners[1] - at) / area);
        if (shares.x >= 0.0f && shares.y >= 0.0f && shares.z >= 0.0f) return shares;
    }
    glm::vec3 best(1.0f, 0.0f, 0.0f);
    float least = std::numeric_limits<float>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const std::size_t next = (k + 1) % 3;
        const glm::vec2 edge = corners[next] - corners[k];
        const float length2 = glm::dot(edge, edge);
        const float along = length2 > 0.0f ? std::clamp(glm::dot(at - corners[k], edge) / length2, 0.0f, 1.0f) : 0.0f;
        const glm::vec2 gap = corners[k] + edge * along - at;
        if (glm::dot(gap, gap) >= least) continue;
        least = glm::dot(gap, gap);
        best = glm::vec3(0.0f);
        best[static_cast<glm::length_t>(k)] = 1.0f - along;
        best[static_cast<glm::length_t>(next)] = along;
    }
    return best;
}

glm::vec2 point_of(const MapCorners& corners, const glm::vec3& shares) {
    return corners[0] * shares.x + corners[1] * shares.y + corners[2] * shares.z;
}

}  // namespace

LightMap::LightMap(const RayScene& scene, ImageSize size, std::vector<Origin> origins)
    : scene_(scene), size_(size), origins_(std::move(origins)) {
    texel_of_index_.assign(static_cast<std::size_t>(size.pixels()), -1);
    std::vector<float> distances(texel_of_index_.size());
    for (std::uint32_t i = 0; i < scene.surfaces().size(); ++i) {
        if (!origins_[i].is_there) continue;
        const auto count = static_cast<std::uint32_t>(scene.surfaces()[i].primitive->indices.size() / 3);
        for (std::uint32_t triangle = 0; triangle < count; ++triangle) add_triangle(i, triangle, distances);
    }
}

void LightMap::add_triangle(std::uint32_t surface, std::uint32_t triangle, std::vector<float>& distances) {
    const MapCorners corners = coordinates_of(*scene_.surfaces()[surface].primitive, triangle);
    const glm::vec2 low = glm::min(corners[0], glm::min(corners[1], corners[2])) - reach_texels;
    const glm::vec2 high = glm::max(corners[0], glm::max(corners[1], corners[2])) + reach_texels;
    const glm::ivec2 origin = origins_[surface].at;
    const int x0 = std::max(static_cast<int>(std::floor(low.x)), -origin.x);
    const int y0 = std::max(static_cast<int>(std::floor(low.y)), -origin.y);
    const int x1 = std::min(static_cast<int>(std::ceil(high.x)), size_.width - origin.x);
    const int y1 = std::min(static_cast<int>(std::ceil(high.y)), size_.height - origin.y);
    for (int y = y0; y < y1; ++y) {
        for (int x = x0; x < x1; ++x) {
            const glm::vec2 at(static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f);
            const float distance = glm::length(point_of(corners, nearest_shares(corners, at)) - at);
            if (distance >= reach_texels) continue;
            const auto index = static_cast<std::size_t>(origin.y + y) * static_cast<std::size_t>(size_.width) +
                               static_cast<std::size_t>(origin.x + x);
            std::int32_t& number = texel_of_index_[index];
            const MapTexel texel{static_cast<std::uint32_t>(index), surface, triangle, at};
            if (number < 0) {
                number = static_cast<std::int32_t>(texels_.size());
                texels_.push_back(texel);
            } else if (distance < distances[index]) {
                texels_[static_cast<std::size_t>(number)] = texel;
            } else {
                continue;
            }
            distances[index] = distance;
        }
    }
}

MapPlace LightMap::place(const MapTexel& texel, const glm::vec2& beside) const {
    const RaySurface& surface = scene_.surfaces()[texel.surface];
    MapPlace made;
    const glm::vec3 shares = nearest_shares(coordinates_of(*surface.primitive, texel.triangle), texel.at + beside);
    // Not on its border: what stands there could not be told from what stands beside it.
    made.shares = glm::mix(shares, glm::vec3(1.0f / 3.0f), 1e-3f);
    made.position = surface.position_at(texel.triangle, made.shares);
    made.side = surface.side_of(texel.triangle);
    made.normal = surface.normal_at(texel.triangle, made.shares);
    // A bent normal may not look behind its surface.
    if (glm::dot(made.normal, made.side) < 0.1f) made.normal = made.side;
    return made;
}

float LightMap::side_m(const MapTexel& texel) const {
    const RaySurface& surface = scene_.surfaces()[texel.surface];
    const MapCorners corners = coordinates_of(*surface.primitive, texel.triangle);
    const glm::vec2 right = corners[1] - corners[0], down = corners[2] - corners[0];
    const auto corner = [&](int i) {
        glm::vec3 shares(0.0f);
        shares[i] = 1.0f;
        return surface.position_at(texel.triangle, shares);
    };
    const float area = glm::length(glm::cross(corner(1) - corner(0), corner(2) - corner(0)));
    return std::sqrt(area / std::max(std::abs(right.x * down.y - right.y * down.x), 1e-12f));
}

std::int32_t LightMap::texel_at(const RayHit& hit) const {
    const Origin& origin = origins_[hit.surface];
    if (!origin.is_there) return -1;
    const MapCorners corners = coordinates_of(*scene_.surfaces()[hit.surface].primitive, hit.triangle);
    const glm::vec2 at = point_of(corners, hit.shares);
    const int x = std::clamp(origin.at.x + static_cast<int>(at.x), 0, size_.width - 1);
    const int y = std::clamp(origin.at.y + static_cast<int>(at.y), 0, size_.height - 1);
    return texel_of_index_[static_cast<std::size_t>(y) * static_cast<std::size_t>(size_.width) +
                           static_cast<std::size_t>(x)];
}

}  // namespace camrig::bake
