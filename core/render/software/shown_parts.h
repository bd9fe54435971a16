#pragma once

#include <algorithm>
#include <array>
#include <cstring>
#include <span>

#include "core/render/software/pixel_fragments.h"
#include "core/render/software/sample_places.h"

/// What one pixel shows, from its fragments: the nearest at each sample, and which of them are one surface.
namespace camrig::render::software {

inline constexpr std::uint32_t no_triangle = ~0u;

/// What shows at some samples of a pixel.
struct Shown {
    SampleMask mask = 0;
    PixelPlane plane;
    float reach = 0.0f;  ///< of the plane
    std::uint32_t triangle = no_triangle;
    glm::vec3 color{0.0f};   ///< of what has no triangle
    bool is_behind = false;  ///< a whole pixel of statics that show one surface: its centre's colour is taken
    int surface = -1;        ///< those of one surface have the first one's number among all that shows
};

/// All of a pixel. No two have a sample together.
class ShownParts {
public:
    void clear() { count_ = 0; }
    std::span<Shown> all() { return {parts_.data(), count_}; }

    /// In place, field by field: a copy of what was only just written waits for it.
    CAMRIG_LANES Shown& append(SampleMask mask, const PixelPlane& plane, float reach) {
        Shown& part = parts_[count_++];
        part.mask = mask;
        part.plane.z = plane.z;
        part.plane.dx = plane.dx;
        part.plane.dy = plane.dy;
        part.reach = reach;
        part.triangle = no_triangle;
        part.is_behind = false;
        return part;
    }

    /// The nearest has a sample; of those as near, the first that came.
    template <typename Isa>
    CAMRIG_LANES void add(const Fragment& fragment) {
        SampleMask mask = fragment.mask;
        bool has_gone = false;
        for (Shown& other : all()) {
            const SampleMask both = other.mask & mask;
            if (both == 0) continue;
            const SampleMask won = both & in_front<Isa>(fragment.plane, other.plane, fragment.reach + other.reach);
            other.mask &= ~won;
            mask &= ~(both & ~won);
            has_gone |= other.mask == 0;
        }
        if (has_gone) {
            const auto gone = std::ranges::remove(all(), SampleMask{0}, &Shown::mask);
            count_ -= gone.size();
        }
        if (mask == 0) return;
        Shown& part = append(mask, fragment.plane, fragment.reach);
        part.triangle = fragment.triangle;
    }

private:
    /// Each has a sample at least, but one of no sample that a pixel of statics may have.
    std::array<Shown, sample_count + 2> parts_;
    std::size_t count_ = 0;
};

/// The corners of a triangle, and its draw with other bits.
using TriangleWords = std::int32_t __attribute__((vector_size(16)));

CAMRIG_LANES bool has_common_corner(TriangleWords a, TriangleWords b) {
    constexpr TriangleWords are_corners{-1, -1, -1, 0};
    const TriangleWords same = ((a == b) | (a == __builtin_shufflevector(b, b, 1, 2, 0, 3)) |
                                (a == __builtin_shufflevector(b, b, 2, 0, 1, 3))) &
                               are_corners;
    using Halves = std::int64_t __attribute__((vector_size(16)));
    const auto halves = reinterpret_cast<Halves>(same);
    return (halves[0] | halves[1]) != 0;
}

/// Triangles of one draw with a common vertex are one surface, shaded once.
CAMRIG_LANES void find_surfaces(const ViewGeometry& geometry, std::span<Shown> shown) {
    const ScreenTriangle* const triangles = geometry.triangles().data();
    std::array<TriangleWords, sample_count + 2> words;
    for (std::size_t i = 0; i < shown.size(); ++i) {
        shown[i].surface = static_cast<int>(i);
        if (shown[i].triangle == no_triangle) {
            words[i] = TriangleWords{-1, -1, -1, -1};  // no triangle's
            continue;
        }
        std::memcpy(&words[i], triangles + shown[i].triangle, sizeof words[i]);
        for (std::size_t k = 0; k < i; ++k) {
            constexpr auto bits_of_draw = static_cast<std::int32_t>(max_draws);
            if (((words[i][3] ^ words[k][3]) & bits_of_draw) != 0 || !has_common_corner(words[i], words[k])) continue;
            shown[i].surface = shown[k].surface;
            break;
        }
    }
}

/// The whole pixel shows the surface that its centre shows.
CAMRIG_LANES bool is_as_its_middle(std::span<const Shown> shown, std::uint32_t number) {
    if (number == 0) return shown.empty();
    SampleMask covered = 0;
    bool has_middle = false;
    for (const Shown& part : shown) {
        if (part.surface != shown.front().surface) return false;
        covered |= part.mask;
        has_middle |= part.triangle + 1 == number;
    }
    return covered == all_samples && has_middle;
}

}  // namespace camrig::render::software
