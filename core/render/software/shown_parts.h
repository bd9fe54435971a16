#pragma once

#include <algorithm>
#include <array>
#include <span>

#include "core/render/software/pixel_fragments.h"
#include "core/render/software/sample_places.h"

/// What one pixel shows, from its fragments: the nearest at each place, and which of them are one surface.
namespace camrig {

inline constexpr std::uint32_t no_triangle = ~0u;

/// What shows at some places of a pixel.
struct Shown {
    SampleMask mask = 0;
    PixelPlane plane;
    std::uint32_t triangle = no_triangle;
    glm::vec3 color{0.0f};   ///< of what has no triangle
    bool is_behind = false;  ///< a whole pixel of statics that show one surface: its middle's colour is taken
    int surface = -1;        ///< those of one surface have the first one's number among all that shows
};

/// All of a pixel. No two have a place together.
class ShownParts {
public:
    void clear() { count_ = 0; }
    std::span<Shown> all() { return {parts_.data(), count_}; }

    /// In place, field by field: a copy of what was only just written waits for it.
    CAMRIG_LANES Shown& append(SampleMask mask, const PixelPlane& plane) {
        Shown& part = parts_[count_++];
        part.mask = mask;
        part.plane.z = plane.z;
        part.plane.dx = plane.dx;
        part.plane.dy = plane.dy;
        part.triangle = no_triangle;
        part.is_behind = false;
        return part;
    }

    /// The nearest has a place; of those as near, the first that came.
    template <typename Isa>
    CAMRIG_LANES void add(const Fragment& fragment) {
        SampleMask mask = fragment.mask;
        bool has_gone = false;
        for (Shown& other : all()) {
            const SampleMask both = other.mask & mask;
            if (both == 0) continue;
            const SampleMask won = both & in_front<Isa>(fragment.plane, other.plane);
            other.mask &= ~won;
            mask &= ~(both & ~won);
            has_gone |= other.mask == 0;
        }
        if (has_gone) {
            const auto gone = std::ranges::remove(all(), SampleMask{0}, &Shown::mask);
            count_ -= gone.size();
        }
        if (mask == 0) return;
        Shown& part = append(mask, fragment.plane);
        part.triangle = fragment.triangle;
    }

private:
    /// Each has a place at least, but one of no place that a pixel of statics may have.
    std::array<Shown, sample_count + 2> parts_;
    std::size_t count_ = 0;
};

/// Triangles of one draw with a common vertex are one surface, shaded once.
CAMRIG_LANES void find_surfaces(const ViewGeometry& geometry, std::span<Shown> shown) {
    const ScreenTriangle* const triangles = geometry.triangles().data();
    for (std::size_t i = 0; i < shown.size(); ++i) {
        shown[i].surface = static_cast<int>(i);
        if (shown[i].triangle == no_triangle) continue;
        const ScreenTriangle& own = triangles[shown[i].triangle];
        for (std::size_t k = 0; k < i; ++k) {
            if (shown[k].triangle == no_triangle || triangles[shown[k].triangle].draw != own.draw) continue;
            const auto& others = triangles[shown[k].triangle].vertices;
            if (std::ranges::find_first_of(own.vertices, others) == own.vertices.end()) continue;
            shown[i].surface = shown[k].surface;
            break;
        }
    }
}

/// The whole pixel shows the surface that its middle shows.
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

}  // namespace camrig
