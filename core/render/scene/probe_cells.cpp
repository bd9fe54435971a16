#include "core/render/scene/probe_cells.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace camrig::render::scene {
namespace {

constexpr float side_m = 0.75f, margin_m = 1.0f;
constexpr float most_cells = 65536.0f;  ///< wider cubes where there would be more
constexpr int wide = 4;                 ///< so many cells on a side are looked at together first

struct Box {
    glm::vec3 low, high;
};

/// Of some places those that may be among the two nearest to a point of the box: no two others are nearer to all of it.
std::vector<std::uint16_t> nearest_to(const Box& box, std::span<const std::uint16_t> of,
                                      std::span<const glm::vec3> places) {
    float first = 1e30f, second = 1e30f;  // of the distances to the farthest corner
    for (const std::uint16_t number : of) {
        const glm::vec3& place = places[number];
        const float farthest = glm::length(glm::max(glm::abs(place - box.low), glm::abs(place - box.high)));
        second = std::min(second, std::max(first, farthest));
        first = std::min(first, farthest);
    }
    // For rounding, of distances and of which cell a point is in.
    const float most = second * 1.001f + 1e-3f;
    std::vector<std::uint16_t> made;
    for (const std::uint16_t number : of) {
        const glm::vec3& place = places[number];
        if (glm::distance(place, glm::clamp(place, box.low, box.high)) <= most) made.push_back(number);
    }
    return made;
}

}  // namespace

ProbeCells::ProbeCells(std::span<const glm::vec3> places) {
    glm::vec3 low(0.0f), high(0.0f);
    if (!places.empty()) low = high = places.front();
    for (const glm::vec3& place : places) {
        low = glm::min(low, place);
        high = glm::max(high, place);
    }
    first_ = glm::dvec3(low) - static_cast<double>(margin_m);
    const glm::vec3 size = high - low + 2.0f * margin_m;
    const auto count_with = [&](float side) { return glm::max(glm::ceil(size / side), 1.0f); };
    float side = side_m;
    for (glm::vec3 count = count_with(side); count.x * count.y * count.z > most_cells; count = count_with(side))
        side *= 1.25f;
    cells_per_m_ = 1.0f / side;
    count_ = glm::ivec3(count_with(side));
    std::vector<glm::vec3> from_first;
    for (const glm::vec3& place : places) from_first.emplace_back(glm::dvec3(place) - first_);
    for (glm::length_t i = 0; i < 3; ++i)
        for (const glm::vec3& place : from_first) places_[static_cast<std::size_t>(i)].push_back(place[i]);

    std::vector<std::uint16_t> all(places.size());
    std::iota(all.begin(), all.end(), std::uint16_t{0});
    const auto box_of = [&](const glm::ivec3& at, int cells) {
        return Box{glm::vec3(at) * side, glm::vec3(at + cells) * side};
    };
    const glm::ivec3 blocks = (count_ + (wide - 1)) / wide;
    std::vector<std::vector<std::uint16_t>> of_blocks;
    for (int z = 0; z < blocks.z; ++z)
        for (int y = 0; y < blocks.y; ++y)
            for (int x = 0; x < blocks.x; ++x)
                of_blocks.push_back(nearest_to(box_of(glm::ivec3(x, y, z) * wide, wide), all, from_first));
    starts_.push_back(0);
    for (int z = 0; z < count_.z; ++z) {
        for (int y = 0; y < count_.y; ++y) {
            for (int x = 0; x < count_.x; ++x) {
                const auto block = static_cast<std::size_t>((z / wide * blocks.y + y / wide) * blocks.x + x / wide);
                const auto near = nearest_to(box_of({x, y, z}, 1), of_blocks[block], from_first);
                near_.insert(near_.end(), near.begin(), near.end());
                starts_.push_back(static_cast<std::uint32_t>(near_.size()));
            }
        }
    }
    near_.insert(near_.end(), all.begin(), all.end());
    starts_.push_back(static_cast<std::uint32_t>(near_.size()));
}

}  // namespace camrig::render::scene
