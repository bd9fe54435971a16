#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include <glm/glm.hpp>

/// Which of some places are the two nearest ones, asked at many points.
namespace camrig::render::scene {

/// The space about the places in cubes, each with all places that may be among the two nearest to a point in it: who
/// looks at those finds what he would among all.
class ProbeCells {
public:
    ProbeCells() = default;
    explicit ProbeCells(std::span<const glm::vec3> places);

    /// The corner of the first cube, world; `places` are from there.
    const glm::dvec3& first() const { return first_; }
    /// By coordinate.
    const std::array<std::vector<float>, 3>& places() const { return places_; }
    std::size_t size() const { return places_[0].size(); }

    float cells_per_m() const { return cells_per_m_; }
    const glm::ivec3& count() const { return count_; }
    /// The cell of a point beyond them, which has all places.
    std::int32_t beyond() const { return count_.x * count_.y * count_.z; }
    std::span<const std::uint16_t> of(std::int32_t cell) const {
        const auto at = static_cast<std::size_t>(cell);
        return std::span(near_).subspan(starts_[at], starts_[at + 1] - starts_[at]);
    }

private:
    glm::dvec3 first_{0.0};
    std::array<std::vector<float>, 3> places_;
    float cells_per_m_ = 1.0f;
    glm::ivec3 count_{0};
    std::vector<std::uint32_t> starts_;  ///< by cell, into near_; then the end
    std::vector<std::uint16_t> near_;
};

}  // namespace camrig::render::scene
